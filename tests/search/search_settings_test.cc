#include "common/config/search_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "common/base/check.h"

namespace powderkeg {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// The message of the Error that setting the option throws.
std::string MessageFor(std::string_view name, std::string_view value) {
  SearchSettings settings;
  try {
    SetOption(settings, name, value);
  } catch (const Error& error) {
    EXPECT_EQ(settings, SearchSettings()) << "a refused option changes nothing";
    return error.what();
  }
  return "no error";
}

TEST(SearchSettings, EmptyTextGivesTheDefaults) {
  EXPECT_EQ(ParseSearchSettings(""), SearchSettings());
}

TEST(SearchSettings, SetsOptionsOfEveryKind) {
  const SearchSettings settings = ParseSearchSettings(
      "simulations=1000,tree=two_player,c_puct_init=1.25,tree_reuse=false,"
      "opponents=idle/harmless/official_simple,memory=reset");
  EXPECT_EQ(settings.simulations, 1000);
  EXPECT_EQ(settings.tree, TreeKind::kTwoPlayer);
  EXPECT_EQ(settings.c_puct_init, 1.25);
  EXPECT_FALSE(settings.tree_reuse);
  EXPECT_THAT(settings.opponents,
              testing::ElementsAre(OpponentModel::kIdle, OpponentModel::kHarmless,
                                   OpponentModel::kOfficialSimple));
  EXPECT_EQ(settings.memory, ModelMemory::kReset);
}

TEST(SearchSettings, OneModelStandsForAllOthers) {
  const SearchSettings settings = ParseSearchSettings("opponents=random");
  EXPECT_THAT(settings.opponents, testing::Each(OpponentModel::kRandom));
}

TEST(SearchSettings, PresetIsAppliedBeforeOtherOptions) {
  SearchSettings expected = PaperSettings();
  expected.simulations = 50;
  EXPECT_EQ(ParseSearchSettings("simulations=50,preset=paper"), expected);
  EXPECT_EQ(ParseSearchSettings("preset=default"), SearchSettings());
  EXPECT_EQ(ParseSearchSettings("preset=gumbel"), ParseSearchSettings("root=gumbel"));
  EXPECT_EQ(ParseSearchSettings("preset=katago"),
            ParseSearchSettings("full_search_share=0.25,forced_playouts=2"));
}

TEST(SearchSettings, UnknownOptionListsTheKnownOnes) {
  EXPECT_THAT(MessageFor("simulation", "5"),
              AllOf(HasSubstr("'simulation'"), HasSubstr("preset"), HasSubstr("simulations"),
                    HasSubstr("tree_reuse")));
}

TEST(SearchSettings, BadValuesSayWhatIsAllowed) {
  EXPECT_THAT(MessageFor("simulations", "0"), AllOf(HasSubstr("'0'"), HasSubstr("from 1 to")));
  EXPECT_THAT(MessageFor("simulations", "12x"), HasSubstr("'12x'"));
  EXPECT_THAT(MessageFor("simulations", ""), HasSubstr("a whole number"));
  EXPECT_THAT(MessageFor("noise_weight", "1.5"), AllOf(HasSubstr("'1.5'"), HasSubstr("0 to 1")));
  EXPECT_THAT(MessageFor("noise_weight", "nan"), HasSubstr("'nan'"));
  EXPECT_THAT(MessageFor("tree", "three_player"), HasSubstr("one_player or two_player"));
  EXPECT_THAT(MessageFor("tree_reuse", "yes"), HasSubstr("false or true"));
  EXPECT_THAT(MessageFor("opponents", "idle/idle"), HasSubstr("three separated by '/'"));
  EXPECT_THAT(MessageFor("opponents", "idle/idle/alien"), HasSubstr("simple_unbiased"));
  EXPECT_THAT(MessageFor("preset", "best"), HasSubstr("default, paper, gumbel or katago"));
  EXPECT_THAT(MessageFor("root", "uct"), AllOf(HasSubstr("'uct'"), HasSubstr("puct or gumbel")));
  EXPECT_THAT(MessageFor("gumbel_considered", "7"), HasSubstr("from 1 to 6"));
  EXPECT_THAT(MessageFor("gumbel_scale", "-1"), HasSubstr("'-1'"));
  EXPECT_THAT(MessageFor("full_search_share", "1.5"), HasSubstr("from 0 to 1"));
  EXPECT_THAT(MessageFor("fast_simulations", "0"), HasSubstr("from 1 to"));
  EXPECT_THAT(MessageFor("forced_playouts", "two"), HasSubstr("a number from 0"));
  EXPECT_THAT(MessageFor("terminal_solver", "on"), HasSubstr("false or true"));
  EXPECT_THAT(MessageFor("raw_network_depth", "-1"), HasSubstr("a whole number from 0"));
  EXPECT_THAT(MessageFor("mate_model", "friend"), HasSubstr("as_opponents, idle"));
  EXPECT_THROW((void)ParseSearchSettings("simulations"), Error);
}

TEST(SearchSettings, TextNamesWhatDiffersFromTheDefaults) {
  EXPECT_EQ(ToText(SearchSettings()), "");
  EXPECT_EQ(ToText(ParseSearchSettings("opponents=idle,simulations=99")),
            "simulations=99,opponents=idle");
  EXPECT_EQ(ParseSearchSettings(ToText(PaperSettings())), PaperSettings());
}

TEST(SearchSettings, ListsEveryOptionWithItsValue) {
  SearchSettings settings;
  for (const SearchOption& option : ListOptions(PaperSettings())) {
    EXPECT_FALSE(option.help.empty());
    SetOption(settings, option.name, option.value);
  }
  EXPECT_EQ(settings, PaperSettings());
}

TEST(SearchSettings, TheMateHasItsOwnModelWhereAsked) {
  SearchSettings settings = ParseSearchSettings("mate_model=raw_network");
  EXPECT_EQ(settings.mate_model, OpponentModel::kRawNetwork);
  EXPECT_EQ(ToText(settings), "mate_model=raw_network");
  SetOption(settings, "mate_model", "as_opponents");
  EXPECT_EQ(settings, SearchSettings());
}

// The message `Search` of the configuration names the same options.
TEST(SearchSettings, EveryOptionIsAFieldOfTheConfiguration) {
  std::ifstream file("proto/config.proto");
  const std::string proto(std::istreambuf_iterator<char>(file), {});
  for (const SearchOption& option : ListOptions({})) {
    EXPECT_THAT(proto, HasSubstr(" " + option.name + " = ")) << option.name;
  }
}

}  // namespace
}  // namespace powderkeg

#include "actors/search/search_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  EXPECT_THAT(MessageFor("preset", "best"), HasSubstr("default or paper"));
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

}  // namespace
}  // namespace powderkeg

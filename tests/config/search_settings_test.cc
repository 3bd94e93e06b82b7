#include "common/config/search_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/check.h"
#include "tests/search/settings_from_text.h"

namespace powderkeg {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// The message of the Error that setting the option throws.
std::string MessageFor(std::string_view name, std::string_view value) {
  try {
    (void)ParseSearchSettings(StrCat(name, "=", value));
  } catch (const Error& error) {
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
  EXPECT_EQ(ParseSearchSettings("preset=gumbel"),
            ParseSearchSettings("root=gumbel,caution=0,room=0,hunt=0,policy_temperature=1"));
  EXPECT_EQ(
      ParseSearchSettings("preset=katago"),
      ParseSearchSettings(
          "full_search_share=0.25,forced_playouts=2,caution=0,room=0,hunt=0,policy_temperature=1"));
}

TEST(SearchSettings, BadValuesSayWhatIsAllowed) {
  EXPECT_THAT(MessageFor("simulations", "0"), AllOf(HasSubstr("is 0"), HasSubstr("from 1 to")));
  EXPECT_THAT(MessageFor("simulations", "12x"), HasSubstr("12x"));
  EXPECT_THAT(MessageFor("simulations", ""), HasSubstr("is \"\"; expected a whole number"));
  EXPECT_THAT(MessageFor("noise_weight", "1.5"), AllOf(HasSubstr("1.5"), HasSubstr("0 to 1")));
  EXPECT_THAT(MessageFor("noise_weight", "nan"), HasSubstr("nan"));
  EXPECT_THAT(MessageFor("tree", "three_player"), HasSubstr("one of one_player, two_player"));
  EXPECT_THAT(MessageFor("tree_reuse", "yes"), HasSubstr("one of false, true"));
  EXPECT_THAT(MessageFor("opponents", "idle/idle"), HasSubstr("3 separated by '/'"));
  EXPECT_THAT(MessageFor("opponents", "idle/idle/idle/idle"), HasSubstr("3 separated by '/'"));
  EXPECT_THAT(MessageFor("opponents", "idle/idle/alien"), HasSubstr("simple_unbiased"));
  EXPECT_THAT(MessageFor("preset", "gumble"), HasSubstr("one of default, paper, gumbel, katago"));
  EXPECT_THAT(MessageFor("mate_model", "friend"), HasSubstr("as_opponents or one of idle"));
}

TEST(SearchSettings, TheMateHasItsOwnModelWhereAsked) {
  EXPECT_EQ(ParseSearchSettings("mate_model=raw_network").mate_model, OpponentModel::kRawNetwork);
  EXPECT_EQ(ParseSearchSettings("mate_model=as_opponents"), SearchSettings());
}

}  // namespace
}  // namespace powderkeg

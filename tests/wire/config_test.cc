#include "common/config/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "common/base/check.h"

namespace powderkeg {
namespace {

using testing::HasSubstr;
using Changes = std::vector<std::string>;

std::string FaultOf(const std::string& text, const Changes& changes = {}) {
  try {
    (void)ParseConfig(text, "run.textproto", changes);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(ConfigTest, AnEmptyFileGivesTheDefaults) {
  EXPECT_EQ(ParseConfig("", "empty", {}), RunConfig{});
  EXPECT_EQ(LoadConfig("", {}), RunConfig{});
}

TEST(ConfigTest, ReadsSettings) {
  const RunConfig config = ParseConfig(
      R"(self_play { games_in_flight: 7 search { simulations: 64 tree: "two_player" } }
         training { learning_rate: 0.01 network: "paper" })",
      "x", {});
  EXPECT_EQ(config.self_play.games_in_flight, 7);
  EXPECT_EQ(config.self_play.search, (Options{{"simulations", "64"}, {"tree", "two_player"}}));
  EXPECT_EQ(config.training.learning_rate, 0.01);
  EXPECT_EQ(config.training.network, "paper");
  EXPECT_EQ(config.training.batch_size, TrainingConfig{}.batch_size);
}

TEST(ConfigTest, ChangesComeAfterTheFileInOrder) {
  const RunConfig config =
      ParseConfig("training { batch_size: 5 }", "x",
                  Changes{"training.batch_size=128", "training.batch_size=64",
                          "self_play.search.simulations=9", "self_play.search.tree_reuse=true",
                          "self_play.opponents=idle,random,harmless", "self_play.seed=0"});
  EXPECT_EQ(config.training.batch_size, 64);
  EXPECT_EQ(config.self_play.search, (Options{{"simulations", "9"}, {"tree_reuse", "true"}}));
  EXPECT_EQ(config.self_play.opponents, (std::array<std::string, 3>{"idle", "random", "harmless"}));
  EXPECT_EQ(config.self_play.seed, 0u);
}

TEST(ConfigTest, ResolvedTextGivesTheSameSettings) {
  const RunConfig config =
      ParseConfig("", "x", Changes{"self_play.search.c_puct_init=0.1", "training.epochs=0.3"});
  const std::string text = ToText(config);
  EXPECT_THAT(text, HasSubstr("checkpoints_kept: 3"));
  EXPECT_EQ(ParseConfig(text, "resolved", {}), config);
}

TEST(ConfigTest, FaultsNameTheirPlace) {
  EXPECT_THAT(FaultOf("training {\n  batchsize: 5\n}"), HasSubstr("run.textproto:2:"));
  EXPECT_THAT(FaultOf("training {\n  batchsize: 5\n}"), HasSubstr("batchsize"));
  EXPECT_THAT(FaultOf("training { batch_size: 5 batch_size: 6 }"), HasSubstr("multiple times"));
  EXPECT_THAT(FaultOf("training { batch_size: \"many\" }"), HasSubstr("run.textproto:1:"));
  EXPECT_THAT(FaultOf("training { batch_size: 0 }"),
              HasSubstr("training.batch_size is 0; expected a number from 1 to"));
  EXPECT_THAT(FaultOf("training { learning_rate: 0 }"), HasSubstr("above 0"));
  EXPECT_THAT(FaultOf("training { learning_rate: nan }"), HasSubstr("learning_rate is nan"));
  EXPECT_THAT(FaultOf("self_play { corners: \"round\" }"),
              HasSubstr("self_play.corners is round; expected one of official permuted"));
  EXPECT_THAT(FaultOf("self_play { opponents: \"idle\" }"),
              HasSubstr("1 values; expected none or 3"));
}

TEST(ConfigTest, BadChangesAreErrors) {
  EXPECT_THAT(FaultOf("", {"training.batch_sizes=5"}), HasSubstr("no setting \"batch_sizes\""));
  EXPECT_THAT(FaultOf("", {"training.batch_size=five"}), HasSubstr("\"five\""));
  EXPECT_THAT(FaultOf("", {"training.batch_size"}), HasSubstr("expected path=value"));
  EXPECT_THAT(FaultOf("", {"=1"}), HasSubstr("expected path=value"));
  EXPECT_THAT(FaultOf("", {"training=1"}), HasSubstr("is a section"));
  EXPECT_THAT(FaultOf("", {"training.batch_size.x=1"}), HasSubstr("has no settings in it"));
  EXPECT_THAT(FaultOf("", {"self_play.search.speed=1"}), HasSubstr("no setting \"speed\""));
}

TEST(ConfigTest, ReadsFiles) {
  const std::string path = testing::TempDir() + "config_test.textproto";
  std::ofstream(path) << "# comment\ntraining { iterations: 3 }\n";
  EXPECT_EQ(LoadConfig(path, {}).training.iterations, 3);
  std::ofstream(path) << "";
  EXPECT_EQ(LoadConfig(path, {}), RunConfig{});
  EXPECT_THROW((void)LoadConfig(path + ".none", {}), Error);
}

TEST(ConfigTest, OutcomesAreWorthInTrainingWhatTheyAreInTheSearch) {
  const auto tied = [](const std::string& text, const Changes& changes) {
    RunConfig config = ParseConfig(text, "x", changes);
    TieOutcomesToSearch(config);
    return config.training;
  };
  const auto draw_value = [&](const Changes& changes) { return tied("", changes).draw_value; };
  const std::string search = "self_play.search.draw_value=-0.5";
  EXPECT_EQ(draw_value({}), std::nullopt);
  EXPECT_EQ(draw_value({search}), -0.5);
  EXPECT_EQ(draw_value({search, "training.draw_value=0.25"}), 0.25);
  EXPECT_EQ(draw_value({search, "training.draw_value=0"}), 0);
  EXPECT_THROW(draw_value({"self_play.search.draw_value=-1.5"}), Error);
  EXPECT_THROW(draw_value({"self_play.search.draw_value=nan"}), Error);
  EXPECT_THAT(FaultOf("training { draw_value: 2 }"), HasSubstr("training.draw_value is 2"));
  // What is resolved and stored keeps them tied.
  const RunConfig config = ParseConfig("", "x", Changes{search});
  const RunConfig stored = ParseConfig(ToText(config), "x", {});
  EXPECT_EQ(stored, config);
  EXPECT_EQ(tied(ToText(config), {"self_play.search.draw_value=-1"}).draw_value, -1);
  EXPECT_EQ(tied("", {"self_play.search.late_win_value=0.5"}).late_win_value, 0.5);
  EXPECT_EQ(tied("", {"training.late_win_value=0.25"}).late_win_value, 0.25);
}

TEST(ConfigTest, TheDigestFollowsTheSettings) {
  SelfPlayConfig config;
  const Sha256Digest digest = SettingsDigest(config);
  EXPECT_EQ(SettingsDigest(SelfPlayConfig{}), digest);
  config.search = {{"simulations", "1"}};
  EXPECT_NE(SettingsDigest(config), digest);
}

}  // namespace
}  // namespace powderkeg

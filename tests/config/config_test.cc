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

RunConfig Filled() {
  RunConfig config;
  FillPlayers(config.self_play);
  return config;
}

TEST(ConfigTest, AnEmptyFileGivesTheDefaults) {
  EXPECT_EQ(ParseConfig("", "empty", {}), Filled());
  EXPECT_EQ(LoadConfig("", {}), Filled());
}

TEST(ConfigTest, ReadsSettings) {
  const RunConfig config = ParseConfig(
      R"(self_play { games_in_flight: 7 search { simulations: 64 tree: "two_player" } }
         training { learning_rate: 0.01 network: "paper" })",
      "x", {});
  EXPECT_EQ(config.self_play.games_in_flight, 7);
  EXPECT_EQ(config.self_play.search.simulations, 64);
  EXPECT_EQ(config.self_play.search.tree, TreeKind::kTwoPlayer);
  EXPECT_EQ(config.training.learning_rate, 0.01);
  EXPECT_EQ(config.training.network, "paper");
  EXPECT_EQ(config.training.batch_size, TrainingConfig{}.batch_size);
}

TEST(ConfigTest, ChangesComeAfterTheFileInOrder) {
  const RunConfig config =
      ParseConfig("training { batch_size: 5 }", "x",
                  Changes{"training.batch_size=128", "training.batch_size=64",
                          "self_play.search.simulations=9", "self_play.search.tree_reuse=false",
                          "self_play.corners=official", "self_play.seed=0"});
  EXPECT_EQ(config.training.batch_size, 64);
  EXPECT_EQ(config.self_play.search.simulations, 9);
  EXPECT_FALSE(config.self_play.search.tree_reuse);
  EXPECT_EQ(config.self_play.corners, StartCorners::kOfficial);
  EXPECT_EQ(config.self_play.seed, 0u);
}

TEST(ConfigTest, ResolvedTextGivesTheSameSettings) {
  const RunConfig config =
      ParseConfig("", "x", Changes{"self_play.search.c_puct_init=0.1", "training.epochs=0.3"});
  const std::string text = ToText(config);
  EXPECT_THAT(text, HasSubstr("checkpoints_kept: 3"));
  EXPECT_THAT(text, HasSubstr("gumbel_c_visit: 50")) << "whole, not only what was set";
  EXPECT_EQ(ParseConfig(text, "resolved", {}), config);
  EXPECT_EQ(ParseSelfPlay(ToText(config.self_play)), config.self_play);
}

// Within a section a preset comes first; a later one replaces what was said before, and what is
// stored is said before every change.
TEST(ConfigTest, APresetReplacesWhatWasSaidBefore) {
  const std::string stored =
      ToText(ParseConfig("self_play { search { simulations: 16 preset: gumbel } }", "x", {}));
  const auto search = [&](const Changes& changes) {
    return ParseConfig(stored, "stored", changes).self_play.search;
  };
  EXPECT_EQ(search({}).simulations, 16);
  EXPECT_EQ(search({}).root, RootSearch::kGumbel);
  EXPECT_EQ(search({"self_play.search.preset=paper"}), PaperSettings());
  EXPECT_EQ(search({"self_play.search.preset=paper", "self_play.search.simulations=5"}).simulations,
            5);
}

// As stored by version 0.1: what was set of the search, and the names of three opponents.
TEST(ConfigTest, ReadsStoredSettingsOfEarlierRuns) {
  const RunConfig config = ParseConfig(R"(self_play {
  environment: "PommeTeamCompetition-v0"
  board_generator: "official"
  corners: "permuted"
  opponents: "simple_unbiased"
  opponents: "idle"
  opponents: "simple_unbiased"
  seed: 1
  games_in_flight: 32
  record_after_death: false
  weights_swap: "at_once"
  evaluator: "auto"
  precision: "auto"
  search {
    preset: "gumbel"
    simulations: 16
    opponents: "simple_unbiased"
    draw_value: -0.5
  }
}
training {
  network: "small"
  learning_rate: 0.002
  weight_decay: 0.0001
  checkpoints_kept: 3
}
)",
                                       "config.textproto", {});
  EXPECT_EQ(config.self_play.search.root, RootSearch::kGumbel);
  EXPECT_EQ(config.self_play.search.simulations, 16);
  EXPECT_EQ(config.self_play.weights_swap, WeightsSwap::kAtOnce);
  EXPECT_THAT(config.self_play.lineups.at(0).seats,
              testing::ElementsAre("me", "simple_unbiased", "idle", "simple_unbiased"));
  EXPECT_EQ(config.training.learning_rate, 0.002);
}

TEST(ConfigTest, WhatAnActorWouldRefuseIsRefused) {
  const auto fault = [](const std::string& change) { return FaultOf("", {change}); };
  EXPECT_EQ(fault("self_play.search.preset=gumble"),
            "--set self_play.search.preset=gumble: self_play.search.preset is gumble; expected one "
            "of default, paper, gumbel, katago");
  EXPECT_THAT(fault("self_play.search.simulations=-3"), HasSubstr("from 1 to 1000000"));
  EXPECT_THAT(fault("self_play.search.memory=infered"), HasSubstr("reset, synchronized, inferred"));
  EXPECT_THAT(fault("self_play.search.noise_weight=7"), HasSubstr("a number from 0 to 1"));
  EXPECT_THAT(fault("self_play.environment=Chess-v0"), HasSubstr("PommeFFACompetition-v0"));
  EXPECT_THAT(fault("self_play.opponents=bob"), HasSubstr("bob"));
}

TEST(ConfigTest, FaultsNameTheirPlace) {
  EXPECT_THAT(FaultOf("training {\n  batchsize: 5\n}"), HasSubstr("run.textproto:2:"));
  EXPECT_THAT(FaultOf("training {\n  batchsize: 5\n}"), HasSubstr("batchsize"));
  EXPECT_THAT(FaultOf("training { batch_size: 5 batch_size: 6 }"), HasSubstr("given twice"));
  EXPECT_THAT(FaultOf("training { batch_size: \"many\" }"), HasSubstr("run.textproto:1:"));
  EXPECT_THAT(FaultOf("training { batch_size: 0 }"),
              HasSubstr("training.batch_size is 0; expected a whole number from 1 to 1048576"));
  EXPECT_THAT(FaultOf("training { learning_rate: 0 }"), HasSubstr("above 0"));
  EXPECT_THAT(FaultOf("training { learning_rate: nan }"), HasSubstr("learning_rate is nan"));
  EXPECT_THAT(FaultOf("self_play { corners: \"round\" }"),
              HasSubstr("self_play.corners is round; expected one of official, permuted"));
  EXPECT_THAT(FaultOf("training: 1"), HasSubstr("run.textproto:1:1: training is a section"));
  EXPECT_THAT(FaultOf("training { seed { } }"), HasSubstr("there is no setting training.seed"));
  EXPECT_THAT(FaultOf("training { epochs { } }"), HasSubstr("has no settings in it"));
}

TEST(ConfigTest, BadChangesAreErrors) {
  EXPECT_THAT(FaultOf("", {"training.batch_sizes=5"}),
              HasSubstr("no setting training.batch_sizes; did you mean training.batch_size?"));
  EXPECT_THAT(FaultOf("", {"training.batch_size=five"}), HasSubstr("training.batch_size is five"));
  EXPECT_THAT(FaultOf("", {"training.batch_size"}), HasSubstr("expected path=value"));
  EXPECT_THAT(FaultOf("", {"=1"}), HasSubstr("expected path=value"));
  EXPECT_THAT(FaultOf("", {"training=1"}), HasSubstr("is a section"));
  EXPECT_THAT(FaultOf("", {"training.batch_size.x=1"}), HasSubstr("has no settings in it"));
  EXPECT_THAT(FaultOf("", {"self_play.search.speed=1"}),
              HasSubstr("no setting self_play.search.speed"));
}

TEST(ConfigTest, NoRunIsSequentialAndContinuous) {
  const Changes both{"training.sequential=true", "training.continuous=true"};
  EXPECT_THROW((void)ParseConfig("", "x", both), Error);
  for (const std::string& one : both) {
    EXPECT_NO_THROW((void)ParseConfig("", "x", Changes{one})) << one;
  }
}

TEST(ConfigTest, ReadsFiles) {
  const std::string path = testing::TempDir() + "config_test.textproto";
  std::ofstream(path) << "# comment\ntraining { iterations: 3 }\n";
  EXPECT_EQ(LoadConfig(path, {}).training.iterations, 3);
  std::ofstream(path) << "";
  EXPECT_EQ(LoadConfig(path, {}), Filled());
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
  EXPECT_EQ(draw_value({}), 0);
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
  config.search.simulations = 1;
  EXPECT_NE(SettingsDigest(config), digest);
}

}  // namespace
}  // namespace powderkeg

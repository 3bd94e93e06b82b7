#include "learner/report/status_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/learner/view_support.h"

namespace powderkeg {
namespace {

using Json = nlohmann::json;

Json Status(const RunView& view) { return Json::parse(StatusJson(view)); }

TEST(StatusJson, SaysWhatTheRunIsAt) {
  const Json json = Status(PlayingRun());
  EXPECT_EQ(json["run"], "quick");
  EXPECT_EQ(json["started_unix_s"], 1'800'000'000);
  EXPECT_EQ(json["state"], "playing");
  EXPECT_FALSE(json.contains("waiting_for"));
  EXPECT_EQ(json["iterations_done"], 2);
  EXPECT_EQ(json["iterations"], 40);
  EXPECT_EQ(json["decisions"], 20'000);
  EXPECT_EQ(json["decisions_wanted"], 100'000);
  EXPECT_EQ(json["intake"]["games"], 22);
  EXPECT_EQ(json["intake"]["pending_games"], 8);
  EXPECT_EQ(json["intake"]["malformed"], 6);
}

TEST(StatusJson, NamesWhatItWaitsFor) {
  RunView view = PlayingRun();
  view.status.straggler = 1234;
  view.status.decisions_beyond = 90'000;
  EXPECT_EQ(Status(view)["state"], "waiting");
  EXPECT_EQ(Status(view)["waiting_for"], "game 1234");
  view.status.actors = 0;
  EXPECT_EQ(Status(view)["waiting_for"], "actors");
}

TEST(StatusJson, ListsTheActors) {
  const Json actors = Status(PlayingRun())["actors"];
  ASSERT_EQ(actors.size(), 2U);
  EXPECT_EQ(actors[1], (Json{{"name", "actor-1"},
                             {"games", 11},
                             {"rejected", 1},
                             {"games_played", 12},
                             {"decisions", 2'400},
                             {"simulations", 38'400},
                             {"evaluations", 50'000},
                             {"batches", 2'000},
                             {"mean_batch", 25},
                             {"games_running", 32},
                             {"tickets", 40},
                             {"spool_games", 3},
                             {"spool_bytes", 4'096},
                             {"oldest_game_s", 2.5},
                             {"weights_version", 7},
                             {"silence_s", 0.25}}));
  EXPECT_EQ(Status({})["actors"], Json::array());
}

TEST(StatusJson, SaysWhatTheLastIterationWas) {
  const Json last = Status(PlayingRun())["last_iteration"];
  EXPECT_EQ(last["iteration"], 2);
  EXPECT_EQ(last["win_rate"], 0.78125);
  EXPECT_EQ(last["exam_games"], nullptr) << "there were none";
  EXPECT_FALSE(Status({}).contains("last_iteration"));
}

TEST(StatusJson, IsOneLineWhateverNamesHold) {
  RunView view = PlayingRun();
  view.run = "a\"b\n</script>\xff";
  const std::string text = StatusJson(view);
  EXPECT_EQ(text.find('\n'), std::string::npos);
  EXPECT_EQ(Json::parse(text)["run"], "a\"b\n</script>\xef\xbf\xbd");
}

}  // namespace
}  // namespace powderkeg

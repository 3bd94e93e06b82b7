#include "actors/arena/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "actors/arena/elo.h"
#include "actors/arena/match_progress.h"

namespace powderkeg {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using namespace std::chrono_literals;

SeatStatistics SomeStatistics() {
  SeatStatistics statistics;
  statistics.moves = 10;
  statistics.actions = {5, 1, 1, 1, 1, 1};
  statistics.searches = 8;
  statistics.simulations = 800;
  statistics.depth_sum = 80;
  statistics.variation_sum = 120;
  statistics.predictions = 20;
  statistics.predictions_right = 15;
  statistics.taken_for = {0, 0, 0, 15, 0, 5};
  statistics.bombs = 3;
  statistics.kicks = 2;
  statistics.kills = 1;
  statistics.own_deaths = 1;
  statistics.cells[0] = 4;
  statistics.cells[120] = 6;
  statistics.windows = 2;
  statistics.window_cells = 9;
  return statistics;
}

PlayedGame GameWith(int number, int outcome, int steps) {
  PlayedGame game;
  game.number = number;
  game.outcomes[0] = static_cast<std::int8_t>(outcome);
  game.died[0] = outcome <= 0;
  game.steps = steps;
  game.statistics[0] = SomeStatistics();
  return game;
}

Match MatchOf(const std::vector<int>& outcomes) {
  Match match;
  for (const int outcome : outcomes) {
    const int number = static_cast<int>(match.games.size());
    match.games.push_back(GameWith(number, outcome, 100 + number));
    match.metrics.simulations += 800;
    match.timed_moves += 10;
  }
  match.metrics.evaluations = 100;
  match.metrics.batches = 10;
  match.seconds = 2;
  match.thread_seconds = 4;
  return match;
}

TEST(Summary, HoldsTheFiguresOfAMatch) {
  const MatchSummary summary = Summarize(MatchSettings(), MatchOf({1, 1, 0, -1}));
  EXPECT_EQ(summary.score, (MatchScore{.wins = 2, .ties = 1, .losses = 1}));
  EXPECT_EQ(summary.deaths, 2u);
  EXPECT_EQ(summary.agents, 4u);
  EXPECT_DOUBLE_EQ(summary.elo.elo, EloFromPoints(2.25 / 4, 4));
  EXPECT_DOUBLE_EQ(summary.steps.mean(), 101.5);
  EXPECT_DOUBLE_EQ(summary.moves_per_game, 10);
  EXPECT_DOUBLE_EQ(summary.mean_depth, 10);
  EXPECT_DOUBLE_EQ(summary.variation_length, 15);
  EXPECT_DOUBLE_EQ(summary.ms_per_move, 100);
  EXPECT_DOUBLE_EQ(summary.simulations_per_s, 1600);
  EXPECT_DOUBLE_EQ(summary.mean_batch, 10);
  EXPECT_DOUBLE_EQ(summary.prediction_accuracy, 0.75);
  EXPECT_DOUBLE_EQ(summary.action_shares[0], 0.5);
  EXPECT_DOUBLE_EQ(summary.bombs_per_game, 3);
  EXPECT_DOUBLE_EQ(summary.kicks_per_game, 2);
  EXPECT_DOUBLE_EQ(summary.kills_per_game, 1);
  EXPECT_DOUBLE_EQ(summary.own_deaths_per_game, 1);
  EXPECT_DOUBLE_EQ(summary.cells_in_window, 4.5);
  EXPECT_EQ(summary.heat_map[0], 16u);
  EXPECT_EQ(summary.heat_map[120], 24u);
}

TEST(Summary, MeansOverBothSeatsOfAnAgentThatIsItsOwnMate) {
  Match match = MatchOf({1, -1});
  match.roles = {0, 2};
  for (PlayedGame& game : match.games) {
    game.statistics[2] = SomeStatistics();
    game.statistics[2].bombs = 5;
    game.died[2] = true;
  }
  const MatchSettings team{.game = GameSettingsFor("PommeTeamCompetition-v0").value()};
  const MatchSummary summary = Summarize(team, match);
  EXPECT_DOUBLE_EQ(summary.moves_per_game, 10);
  EXPECT_DOUBLE_EQ(summary.bombs_per_game, 4);
  EXPECT_EQ(summary.deaths, 3u);
  EXPECT_EQ(summary.agents, 4u);
  EXPECT_NEAR(summary.elo.elo, 0, 1e-9);
}

TEST(Summary, OfAnAgentThatNeverSearchedHasNoSearchFigures) {
  Match match = MatchOf({1});
  match.games[0].statistics[0] = {};
  const MatchSummary summary = Summarize(MatchSettings(), match);
  EXPECT_EQ(summary.mean_depth, 0);
  EXPECT_EQ(summary.prediction_accuracy, -1);
  EXPECT_EQ(summary.cells_in_window, 0);
}

TEST(Compare, GoesBoardByBoard) {
  const Difference difference =
      Compare(MatchSettings(), MatchOf({1, 1, 0, -1}), MatchOf({1, -1, -1, -1}));
  EXPECT_DOUBLE_EQ(difference.win_rate, 0.25);
  EXPECT_DOUBLE_EQ(difference.score, 0.375);
  EXPECT_NEAR(difference.win_interval.low, 0.25 - 1.959963984540054 * 0.25, 1e-12);
  EXPECT_DOUBLE_EQ(difference.elo.elo, EloFromPoints(2.25 / 4, 4) - EloFromPoints(0.25, 4));
  const Difference none = Compare(MatchSettings(), MatchOf({1, 0}), MatchOf({1, 0}));
  EXPECT_EQ(none.win_interval, (Interval{0, 0}));
}

TEST(Compare, LooksAtTheGamesThatBothPlayed) {
  const Difference difference = Compare(MatchSettings(), MatchOf({1, 1}), MatchOf({1, -1, 1, 1}));
  EXPECT_DOUBLE_EQ(difference.win_rate, 0.5);
}

Contender ContenderOf(const std::string& agent, int simulations, const Match& match) {
  Contender contender{agent, "simple_unbiased", simulations, match, {}, {}, {}, {}};
  contender.summary = Summarize(MatchSettings(), match);
  return contender;
}

std::vector<Contender> SomeContenders() {
  const Match match = MatchOf({1, 1, 0, -1});
  std::vector<Contender> contenders = {ContenderOf("search:model=\"a\\b\"", 250, match),
                                       ContenderOf("idle", 0, match)};
  contenders[1].difference = Compare(MatchSettings(), contenders[1].match, contenders[0].match);
  SequentialTest test(ParseQuestion("win_rate=0.1..0.9"), /*min_games=*/1);
  while (test.Add(1) == Answer::kOpen) {
  }
  contenders[1].test = test.state();
  return contenders;
}

TEST(Report, RatesEverybodyWhereMoreThanTwoMet) {
  Match match = MatchOf({1, 1, 1, -1});
  for (PlayedGame& game : match.games) {
    game.outcomes[1] = static_cast<std::int8_t>(-game.outcomes[0]);
    game.outcomes[2] = game.outcomes[3] = -1;
    for (std::uint32_t role = 0; role < 4; ++role) game.statistics[role].moves = 50 - 10 * role;
  }
  Contender contender = ContenderOf("a", 0, match);
  contender.roles = {"a", "b", "c", "c"};
  const std::string text = ReportText(std::vector{contender});
  const std::size_t ratings = text.find("rating  [95 %]");
  ASSERT_NE(ratings, std::string::npos);
  EXPECT_LT(text.find("  a\n", ratings), text.find("  b\n", ratings));
  EXPECT_LT(text.find("  b\n", ratings), text.find("  c\n", ratings));
  EXPECT_THAT(text, HasSubstr("  16  c\n")) << "two seats against two others in four games";
  contender.roles = {"a", "b", "b", "b"};
  EXPECT_THAT(ReportText(std::vector{contender}), Not(HasSubstr("rating")));
  contender.teams = true;
  contender.roles = {"a", "b", "a", "c"};
  EXPECT_THAT(ReportText(std::vector{contender}), HasSubstr("  8  b\n")) << "but not its mate";
}

TEST(Report, ShowsFiguresToPeople) {
  const std::string text = ReportText(SomeContenders());
  EXPECT_THAT(text, HasSubstr("win     0.500  [0.150, 0.850]  2"));
  EXPECT_THAT(text, HasSubstr("Elo     +235 [-69, +538]  over the average opponent"));
  EXPECT_THAT(text, HasSubstr("predicted at the root: 75.0 %"));
  EXPECT_THAT(text, HasSubstr("opponents taken for  simple_unbiased 0.750  predicted 0.250\n"));
  EXPECT_THAT(text, HasSubstr("a game  bombs 3.00  kicks 2.00  kills 1.00  own deaths 1.000  "
                              "cells in 20 steps 4.50"));
  EXPECT_THAT(text, HasSubstr("against the first, board by board: win +0.000 [+0.000, +0.000]"));
  EXPECT_THAT(text, HasSubstr("Elo +0 [+0, +0]"));
  EXPECT_THAT(text, HasSubstr("question win_rate=0.1..0.9: 0.9 after 2 games"));
  EXPECT_THAT(text, HasSubstr("\n 0.500 [0.150, 0.850]   0.250   0.250   0.500   +235"));
  EXPECT_THAT(ReportText(std::vector{SomeContenders()[0]}), Not(HasSubstr("kicks  kills")));
}

TEST(Report, ShowsTheSpreadBetweenModels) {
  std::vector<Contender> models = {ContenderOf("search:model=a", 250, MatchOf({1, 1, 0, -1})),
                                   ContenderOf("search:model=b", 250, MatchOf({1, -1, -1, -1})),
                                   ContenderOf("idle", 0, MatchOf({1}))};
  EXPECT_THAT(ReportText(models), Not(HasSubstr("between")));
  models[0].settings = models[1].settings = "search";
  const std::string text = ReportText(models);
  EXPECT_THAT(text, HasSubstr("\nsearch, mean +- standard deviation between 2 models\n"
                              "  win         0.375 +- 0.177   of 8 games 0.375 [0.137, 0.694]\n"
                              "  tie         0.125 +- 0.177   of 8 games 0.125 [0.022, 0.471]\n"));
  EXPECT_THAT(text, HasSubstr("  variation  15.000 +- 0.000"));
  const auto json = nlohmann::json::parse(ReportJson(models));
  EXPECT_EQ(json["contenders"][1]["settings"], "search");
  EXPECT_FALSE(json["contenders"][2].contains("settings"));
}

TEST(Report, IsJsonThatProgramsRead) {
  const auto json = nlohmann::json::parse(ReportJson(SomeContenders()));
  const auto& search = json["contenders"][0];
  EXPECT_EQ(search["agent"], "search:model=\"a\\b\"");
  EXPECT_EQ(search["simulations"], 250);
  EXPECT_EQ(search["win"], 0.5);
  EXPECT_NEAR(search["win_low"], 0.150039, 1e-6);
  EXPECT_EQ(search["share_stop"], 0.5);
  EXPECT_EQ(search["taken_for_predicted"], 0.25);
  EXPECT_EQ(search["kills"], 1);
  EXPECT_TRUE(search["elo_difference"].is_null());
  EXPECT_FALSE(search.contains("question"));
  EXPECT_EQ(search["heat_map"].size(), 11u);
  EXPECT_EQ(search["heat_map"][0][0], 16);
  EXPECT_EQ(search["heat_map"][10][10], 24);
  const auto& idle = json["contenders"][1];
  EXPECT_EQ(idle["score_difference"], 0);
  EXPECT_EQ(idle["question"], "win_rate=0.1..0.9");
  EXPECT_EQ(idle["answer"], "0.9");
}

TEST(Report, HasNullForWhatIsInfinite) {
  const std::vector<Contender> perfect = {ContenderOf("search", 250, MatchOf({1, 1}))};
  const auto json = nlohmann::json::parse(ReportJson(perfect));
  EXPECT_TRUE(json["contenders"][0]["elo"].is_null());
  EXPECT_GT(json["contenders"][0]["elo_low"], 0);
  EXPECT_THAT(TableCsv(perfect), HasSubstr(",,"));
}

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(TableCsv, HasALineOfEqualLengthForEachContender) {
  const std::vector<std::string> lines = Lines(TableCsv(SomeContenders()));
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_THAT(lines[0], HasSubstr("number,series,simulations,games,win,win_low,win_high,tie,"));
  EXPECT_THAT(lines[0], HasSubstr(",cell_120,agent,opponents"));
  EXPECT_THAT(lines[1], HasSubstr("0,0,250,4,0.5,0.1500"));
  EXPECT_THAT(lines[2], HasSubstr(",24,\"idle\",\"simple_unbiased\""));
  for (const std::string& line : lines) {
    EXPECT_EQ(std::ranges::count(line, ','), std::ranges::count(lines[0], ','));
  }
}

TEST(TableCsv, PutsAgentsThatDifferInSimulationsAloneIntoASeries) {
  const Match match = MatchOf({1});
  const std::vector<Contender> contenders = {
      ContenderOf("search", 250, match),
      ContenderOf("search:simulations=50,tree=two_player", 50, match),
      ContenderOf("search:simulations=50", 50, match),
      ContenderOf("search:tree=two_player,simulations=70", 70, match)};
  const std::vector<std::string> lines = Lines(TableCsv(contenders));
  EXPECT_TRUE(lines[1].starts_with("0,0,250,"));
  EXPECT_TRUE(lines[2].starts_with("1,1,50,"));
  EXPECT_TRUE(lines[3].starts_with("2,0,50,"));
  EXPECT_TRUE(lines[4].starts_with("3,1,70,"));
}

TEST(GamesCsv, HasALineForEachGame) {
  EXPECT_THAT(GamesCsv(SomeContenders()), HasSubstr("\n\"idle\",3,0,0,-1,1,103,10,800,3,2,1,1\n"));
}

TEST(MatchProgress, PrintsPlainLinesAtMostEveryTenSecondsAndTheLastOne) {
  std::ostringstream out;
  const MatchProgress::Clock::time_point start;
  MatchProgress progress(out, MatchProgress::Style::kPlain, "idle", /*games=*/4);
  progress.Start(start);
  progress.AddGame(GameWith(0, 1, 100), start + 1s);
  progress.AddGame(GameWith(1, 1, 100), start + 11s);
  progress.AddGame(GameWith(2, 0, 100), start + 12s);
  progress.AddGame(GameWith(3, -1, 100), start + 13s);
  progress.Pause(start + 13s);
  EXPECT_EQ(out.str(),
            "idle: 4 games\n"
            "2/4  win 1.000 [0.342, 1.000]  tie 0.000  loss 0.000  11 s left\n"
            "4/4  win 0.500 [0.150, 0.850]  tie 0.250  loss 0.250  0 s left\n");
}

TEST(MatchProgress, WritesOverOneLineOnATerminal) {
  std::ostringstream out;
  const MatchProgress::Clock::time_point start;
  MatchProgress progress(out, MatchProgress::Style::kTerminal, "idle", /*games=*/2);
  progress.Start(start);
  progress.AddGame(GameWith(0, 1, 100), start + 1s);
  progress.AddGame(GameWith(1, 1, 100), start + 2s);
  progress.Pause(start + 2s);
  EXPECT_THAT(out.str(), HasSubstr("\r[============            ] 1/2"));
  EXPECT_THAT(out.str(), HasSubstr("\r[========================] 2/2"));
  EXPECT_EQ(out.str().back(), '\n');
}

TEST(MatchProgress, LeavesPausesOutOfTheTimeAndShowsTheTest) {
  std::ostringstream out;
  const MatchProgress::Clock::time_point start;
  MatchProgress progress(out, MatchProgress::Style::kTerminal, "idle", /*games=*/4);
  progress.Start(start);
  progress.AddGame(GameWith(0, 1, 100), start + 10s);
  progress.Pause(start + 10s);
  SequentialTest test(ParseQuestion("win_rate=0.5..0.6"), /*min_games=*/1);
  test.Add(1);
  progress.SetTest(test.state());
  progress.Start(start + 1000s);
  progress.AddGame(GameWith(1, 1, 100), start + 1010s);
  EXPECT_THAT(out.str(), HasSubstr("20 s left  llr +0.18 of -2.94, +2.94"));
}

}  // namespace
}  // namespace powderkeg

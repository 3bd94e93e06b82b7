#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "actors/arena/match.h"
#include "actors/arena/progress.h"
#include "actors/arena/report.h"

namespace powderkeg {
namespace {

using ::testing::HasSubstr;
using namespace std::chrono_literals;

const ModelLoader kNoModels = [](const std::string& file) -> Model {
  throw Error("no model " + file);
};

Lineup LineupOf(const std::string& agent, const std::string& opponents) {
  return {ParseAgent(agent), ParseAgent(opponents), ParseAgent(opponents), ParseAgent(opponents)};
}

Match PlayQuietly(const Lineup& lineup, const MatchSettings& settings) {
  return PlayMatch(lineup, settings, kNoModels, [](const PlayedGame&) {});
}

std::vector<std::array<int, 3>> FiguresOf(const Match& match) {
  std::vector<std::array<int, 3>> figures;
  for (const PlayedGame& game : match.games) {
    figures.push_back({game.number, game.outcomes[0], game.steps});
  }
  return figures;
}

TEST(Match, IsTheSameOverThreadCountsAndGamesInFlight) {
  const Lineup lineup = LineupOf("search:simulations=4", "simple_unbiased");
  MatchSettings settings{.seed = 5, .games = 12, .threads = 1, .games_in_flight = 1};
  const auto expected = FiguresOf(PlayQuietly(lineup, settings));
  settings.threads = 3;
  settings.games_in_flight = 4;
  EXPECT_EQ(FiguresOf(PlayQuietly(lineup, settings)), expected);
  settings.seed = 6;
  EXPECT_NE(FiguresOf(PlayQuietly(lineup, settings)), expected);
}

TEST(Match, RotatesSeatsAndKeepsBoardsForEveryCandidate) {
  const MatchSettings settings;
  const Lineup lineup = LineupOf("search", "idle");
  for (int number = 0; number < 8; ++number) {
    const GameSetup setup = SetupOf(settings, lineup, number);
    for (AgentId seat = 0; seat < kAgentCount; ++seat) {
      EXPECT_EQ(setup.seats[seat].searches, seat == number % kAgentCount);
    }
    EXPECT_EQ(setup.seed, SetupOf(settings, LineupOf("random", "idle"), number).seed);
  }
  EXPECT_NE(SetupOf(settings, lineup, 0).seed, SetupOf(settings, lineup, 4).seed);
}

TEST(Match, OfEqualAgentsGivesEveryRoleItsShare) {
  const MatchSettings settings{.seed = 1, .games = 400};
  const Match match = PlayQuietly(LineupOf("simple_unbiased", "simple_unbiased"), settings);
  for (int role = 0; role < kAgentCount; ++role) {
    std::uint64_t wins = 0;
    for (const PlayedGame& game : match.games) wins += game.outcomes[role] > 0 ? 1 : 0;
    EXPECT_GT(wins, 50u) << "role " << role;
    EXPECT_LT(wins, 150u) << "role " << role;
  }
  EXPECT_EQ(match.metrics.games, 400u);
}

TEST(Match, PlaysTeamsAndDuels) {
  MatchSettings settings{.game = GameSettingsFor("PommeTeamCompetition-v0").value(), .games = 8};
  for (const PlayedGame& game :
       PlayQuietly(LineupOf("simple_unbiased", "simple_unbiased"), settings).games) {
    EXPECT_EQ(game.outcomes[0], game.outcomes[2]);
    EXPECT_EQ(game.outcomes[1], game.outcomes[3]);
    EXPECT_EQ(game.seat, game.number % 4);
  }
  settings.game = GameSettingsFor("OneVsOne-v0").value();
  for (const PlayedGame& game : PlayQuietly(LineupOf("random", "idle"), settings).games) {
    EXPECT_EQ(game.outcomes[0], -game.outcomes[1]);
    EXPECT_EQ(game.seat, game.number % 2);
  }
}

TEST(Match, ReportsAModelThatCannotBeLoaded) {
  const MatchSettings settings{.games = 2, .threads = 2};
  EXPECT_THROW((void)PlayQuietly(LineupOf("search:model=absent", "idle"), settings), Error);
}

PlayedGame GameWith(int number, int outcome, int steps) {
  PlayedGame game;
  game.number = number;
  game.outcomes[0] = static_cast<std::int8_t>(outcome);
  game.steps = steps;
  SeatStatistics& statistics = game.statistics[0];
  statistics.moves = 10;
  statistics.actions = {5, 1, 1, 1, 1, 1};
  statistics.searches = 8;
  statistics.simulations = 800;
  statistics.depth_sum = 80;
  statistics.predictions = 20;
  statistics.predictions_right = 15;
  return game;
}

Match MatchOf(const std::vector<int>& outcomes) {
  Match match;
  for (const int outcome : outcomes) {
    const int number = static_cast<int>(match.games.size());
    match.games.push_back(GameWith(number, outcome, 100 + number));
    match.metrics.simulations += 800;
  }
  match.metrics.evaluations = 100;
  match.metrics.batches = 10;
  match.seconds = 2;
  match.thread_seconds = 4;
  return match;
}

TEST(Report, SummarisesAMatch) {
  const MatchSummary summary = Summarize(MatchSettings(), MatchOf({1, 1, 0, -1}));
  EXPECT_EQ(summary.score, (MatchScore{.wins = 2, .ties = 1, .losses = 1}));
  EXPECT_DOUBLE_EQ(summary.steps.mean(), 101.5);
  EXPECT_DOUBLE_EQ(summary.mean_depth, 10);
  EXPECT_DOUBLE_EQ(summary.ms_per_move, 100);
  EXPECT_DOUBLE_EQ(summary.simulations_per_s, 1600);
  EXPECT_DOUBLE_EQ(summary.mean_batch, 10);
  EXPECT_DOUBLE_EQ(summary.prediction_accuracy, 0.75);
  EXPECT_DOUBLE_EQ(summary.action_shares[0], 0.5);
}

TEST(Report, ComparesBoardByBoard) {
  const Difference difference = Compare(MatchOf({1, 1, 0, -1}), MatchOf({1, -1, -1, -1}));
  EXPECT_DOUBLE_EQ(difference.win_rate, 0.25);
  EXPECT_DOUBLE_EQ(difference.score, 0.375);
  EXPECT_NEAR(difference.win_interval.low, 0.25 - 1.959963984540054 * 0.25, 1e-12);
  const Difference none = Compare(MatchOf({1, 0}), MatchOf({1, 0}));
  EXPECT_EQ(none.win_interval, (Interval{0, 0}));
}

TEST(Report, ShowsFiguresAsTextJsonAndCsv) {
  std::vector<Contender> contenders;
  for (const char* agent : {"search:model=\"a\\b\"", "idle"}) {
    Contender contender{agent, "simple_unbiased", MatchOf({1, 1, 0, -1}), {}};
    contender.summary = Summarize(MatchSettings(), contender.match);
    contenders.push_back(contender);
  }
  const std::string text = ReportText(contenders);
  EXPECT_THAT(text, HasSubstr("win     0.500  [0.150, 0.850]  2"));
  EXPECT_THAT(text, HasSubstr("predicted at the root: 75.0 %"));
  EXPECT_THAT(text, HasSubstr("against the first, board by board: win +0.000 [+0.000, +0.000]"));
  const std::string json = ReportJson(contenders);
  EXPECT_THAT(json, HasSubstr(R"("agent": "search:model=\"a\\b\"", "opponents")"));
  EXPECT_THAT(json, HasSubstr(R"("win": 0.500000, "win_low": 0.150039)"));
  EXPECT_THAT(json, HasSubstr(R"("actions": {"stop": 0.50000, "up": 0.10000)"));
  EXPECT_THAT(ReportCsv(contenders), HasSubstr("\n\"idle\",3,0,0,-1,103,10,800\n"));
}

TEST(Progress, PrintsPlainLinesAtMostEveryTenSecondsAndTheLastOne) {
  std::ostringstream out;
  const Progress::Clock::time_point start;
  Progress progress(out, Progress::Style::kPlain, "idle", /*games=*/4, start);
  progress.AddGame(GameWith(0, 1, 100), start + 1s);
  progress.AddGame(GameWith(1, 1, 100), start + 11s);
  progress.AddGame(GameWith(2, 0, 100), start + 12s);
  progress.AddGame(GameWith(3, -1, 100), start + 13s);
  progress.Finish();
  EXPECT_EQ(out.str(),
            "idle: 4 games\n"
            "2/4  win 1.000 [0.342, 1.000]  tie 0.000  loss 0.000  11 s left\n"
            "4/4  win 0.500 [0.150, 0.850]  tie 0.250  loss 0.250  0 s left\n");
}

TEST(Progress, WritesOverOneLineOnATerminal) {
  std::ostringstream out;
  const Progress::Clock::time_point start;
  Progress progress(out, Progress::Style::kTerminal, "idle", /*games=*/2, start);
  progress.AddGame(GameWith(0, 1, 100), start + 1s);
  progress.AddGame(GameWith(1, 1, 100), start + 2s);
  progress.Finish();
  EXPECT_THAT(out.str(), HasSubstr("\r[============            ] 1/2"));
  EXPECT_THAT(out.str(), HasSubstr("\r[========================] 2/2"));
  EXPECT_EQ(out.str().back(), '\n');
}

}  // namespace
}  // namespace powderkeg

#include "learner/league/league.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "common/base/check.h"
#include "learner/league/exams.h"
#include "tests/learner/record_support.h"

namespace powderkeg {
namespace {

using testing::HasSubstr;

const std::vector<std::string> kPlayers = {"me", "past", "script"};

// Seats with (player, version, steps lived); the game took as long as the last of them.
GameResult Free(std::array<Finish, kAgentCount> finishes, std::uint8_t winners, bool done = true) {
  return {finishes,
          {.done = done,
           .result = !done          ? Result::kIncomplete
                     : winners != 0 ? Result::kWin
                                    : Result::kTie,
           .winners = winners,
           .rewards = {}}};
}

Finish Of(std::uint8_t player, std::uint32_t version, std::uint16_t lasted) {
  return {.player = player, .weights_version = version, .mate = -1, .lasted = lasted};
}

double EloOf(const League& league, const std::string& name) {
  for (const RatedName& rated : league.Ratings()) {
    if (rated.name == name) return rated.rating.elo;
  }
  ADD_FAILURE() << name << " is not rated";
  return 0;
}

TEST(League, WhoeverOutlivesAnotherHasBeatenIt) {
  const TemporaryFolder folder;
  League league(folder.path() / "league.csv", kPlayers, 0);
  const GameResult game =
      Free({Of(0, 5, 90), Of(1, 3, 50), Of(1, 2, 50), Of(2, 0, 20)}, /*winners=*/0b0001);
  for (int i = 0; i < 20; ++i) league.Add(1, std::span(&game, 1));
  EXPECT_GT(EloOf(league, "v5"), EloOf(league, "v3"));
  EXPECT_NEAR(EloOf(league, "v3"), EloOf(league, "v2"), 1e-6) << "they died together";
  EXPECT_GT(EloOf(league, "v2"), EloOf(league, "script"));
  EXPECT_EQ(league.Ratings().front().name, "v5");
}

TEST(League, EqualContestantsMatesAndUnknownResultsDoNotCount) {
  const TemporaryFolder folder;
  League league(folder.path() / "league.csv", kPlayers, 0);
  const GameResult game = Free({Of(0, 5, 40), Of(0, 5, 30), Of(2, 0, 40), Of(1, 3, 40)},
                               /*winners=*/0, /*done=*/false);
  league.Add(1, std::span(&game, 1));
  for (const RatedName& rated : league.Ratings()) {
    // v5 lived as long as the script and v3 when the game was cut, but its twin died before them.
    EXPECT_LE(rated.games, 2u) << rated.name;
  }
}

TEST(League, ATeamsResultCountsForBothOfIt) {
  const TemporaryFolder folder;
  League league(folder.path() / "league.csv", kPlayers, 0);
  GameResult game = Free({Of(0, 5, 10), Of(2, 0, 80), Of(0, 5, 90), Of(2, 0, 90)}, 0b0101);
  for (std::uint8_t seat = 0; seat < kAgentCount; ++seat) {
    game.finishes[seat].mate = static_cast<AgentId>((seat + 2) % kAgentCount);
  }
  league.Add(1, std::span(&game, 1));
  EXPECT_GT(EloOf(league, "v5"), EloOf(league, "script"));
  EXPECT_EQ(league.Ratings().front().games, 4u);
}

TEST(League, MeetsThoseMoreOftenThatItBeatsLess) {
  const TemporaryFolder folder;
  League league(folder.path() / "league.csv", kPlayers, 0);
  const GameResult won = Free({Of(0, 9, 90), Of(1, 8, 20), {}, {}}, 0b0001);
  const GameResult lost = Free({Of(0, 9, 20), Of(1, 7, 90), {}, {}}, 0b0010);
  const std::vector<GameResult> games = {won, won, won, won, won, won, lost, lost, lost};
  league.Add(8, games);
  Rng rng(1);
  std::map<std::uint32_t, int> drawn;
  for (int i = 0; i < 2000; ++i) ++drawn[league.DrawPast(2, 9, rng)];
  EXPECT_THAT(drawn, testing::SizeIs(3)) << "9 - 1, 9 - 2, 9 - 4";
  EXPECT_GT(drawn[7], 5 * drawn[8]);
  EXPECT_GT(drawn[5], drawn[8]) << "never met: perhaps strong";
  EXPECT_EQ(league.DrawPast(2, 2, rng), 0u) << "nobody is older";
}

TEST(League, ARestartKnowsWhatTheCheckpointCounts) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "league.csv";
  const GameResult first = Free({Of(0, 2, 90), Of(2, 0, 20), {}, {}}, 0b0001);
  const GameResult second = Free({Of(0, 3, 90), Of(2, 0, 20), {}, {}}, 0b0001);
  {
    League league(file, kPlayers, 0);
    league.Add(1, std::span(&first, 1));
    league.Add(2, std::span(&second, 1));
  }
  EXPECT_EQ(League(file, kPlayers, 2).Ratings().size(), 3u);
  EXPECT_EQ(League(file, kPlayers, 1).Ratings().size(), 2u) << "iteration 2 is repeated";
}

TEST(League, ADamagedFileNamesItsLine) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "league.csv";
  std::ofstream(file) << "iteration,first,second,wins,ties,losses\n1,v2,script,1,x,0\n";
  try {
    const League league(file, kPlayers, 1);
    FAIL() << "expected an error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("league.csv:2"));
  }
}

TEST(League, TellsHowFarTheNewestVersionHasCome) {
  const TemporaryFolder folder;
  League league(folder.path() / "league.csv", kPlayers, 0);
  EXPECT_FALSE(league.Progress());
  const GameResult game = Free({Of(0, 12, 90), Of(1, 3, 50), Of(2, 0, 20), {}}, 0b0001);
  for (int i = 0; i < 20; ++i) league.Add(1, std::span(&game, 1));
  ASSERT_TRUE(league.Progress());
  EXPECT_NEAR(league.Progress()->elo, EloOf(league, "v12") - EloOf(league, "v3"), 1e-9);
  EXPECT_GT(league.Progress()->elo, league.Progress()->half_interval);
  EXPECT_THAT(league.RatingsCsv(), HasSubstr("\nv12,40,"));
}

// Two exams and a line-up that teaches.
RunGames ExamGames() {
  SelfPlayConfig config;
  config.players = {{.name = "me", .teaches = PlayerSpec::Teaches::kSearch}};
  config.lineups = {{.seats = {"me", "me", "me", "me"}},
                    {.exam = true, .seats = {"me", "idle", "idle", "idle"}},
                    {.exam = true, .seats = {"me", "random", "idle", "random"}}};
  return RunGames(config);
}

GameResult Exam(std::uint8_t lineup, std::uint32_t version, std::int8_t outcome) {
  GameResult result = Free({Of(0, version, 90), Of(1, 0, 50), Of(1, 0, 50), Of(1, 0, 20)}, 0b0001);
  result.lineup = lineup;
  result.finishes[0].counts = true;
  result.finishes[0].outcome = outcome;
  return result;
}

TEST(Exams, CountEachExamAndVersionApart) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "exams.csv";
  const std::vector<GameResult> results = {Exam(0, 5, 1), Exam(1, 5, 1), Exam(1, 4, -1),
                                           Exam(1, 5, 1), Exam(2, 5, 0)};
  {
    Exams exams(file, ExamGames(), 0);
    exams.Add(6, results);
    exams.Add(7, std::span(results).last(1));
  }
  const Exams exams(file, ExamGames(), 6);
  ASSERT_EQ(exams.Of(6).size(), 2u) << "those that teach sit no exam";
  EXPECT_EQ(exams.Of(6)[0].exam, "me + 2 random + idle");
  EXPECT_EQ(exams.Of(6)[1].exam, "me + 3 idle");
  EXPECT_EQ(exams.Of(6)[1].score, (MatchScore{.wins = 2, .ties = 0, .losses = 1}));
  EXPECT_EQ(exams.Of(7).size(), 0u) << "iteration 7 is repeated";
  EXPECT_EQ(exams.CsvAfter(5),
            "iteration,version,exam,wins,ties,losses\n"
            "6,4,me + 3 idle,0,0,1\n"
            "6,5,me + 2 random + idle,0,1,0\n"
            "6,5,me + 3 idle,2,0,0\n");
}

}  // namespace
}  // namespace powderkeg

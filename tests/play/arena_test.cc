#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>

#include "actors/arena/contest.h"
#include "actors/arena/match.h"
#include "tests/pommerman/board_reader.h"

namespace powderkeg {
namespace {

using ::testing::HasSubstr;

const ModelLoader kNoModels = [](const std::string& file) -> Model {
  throw Error("no model " + file);
};

MatchLineup LineupOf(const std::string& agent, const std::string& opponents) {
  return {ParseAgent(agent), ParseAgent(opponents), ParseAgent(opponents), ParseAgent(opponents)};
}

Match PlayQuietly(const MatchLineup& lineup, const MatchSettings& settings,
                  const ModelLoader& loader = kNoModels) {
  MatchPlayer player(lineup, settings, loader);
  player.Play(settings.games, {.on_game = [](const PlayedGame&) {}, .is_enough = nullptr});
  return player.match();
}

std::vector<std::array<int, 3>> FiguresOf(const Match& match) {
  std::vector<std::array<int, 3>> figures;
  for (const PlayedGame& game : match.games) {
    figures.push_back({game.number, game.outcomes[0], game.steps});
  }
  return figures;
}

TEST(Match, IsTheSameOverThreadCountsAndGamesInFlight) {
  const MatchLineup lineup = LineupOf("search:simulations=4", "simple_unbiased");
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
  const MatchLineup lineup = LineupOf("search", "idle");
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

// Answers what is no number from a batch on.
class FailingEvaluator final : public Evaluator {
 public:
  explicit FailingEvaluator(int good_batches) : good_batches_(good_batches) {}
  void Evaluate(const GameSettings& settings, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    UniformEvaluator().Evaluate(settings, positions, evaluations);
    if (good_batches_-- > 0) return;
    evaluations.back().policy[3] = std::numeric_limits<float>::quiet_NaN();
    asked = ToText(*positions.back().state);
  }
  [[nodiscard]] std::string name() const override { return "failing"; }

  std::string asked;

 private:
  int good_batches_;
};

std::string TextOf(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(Match, StopsWithThePositionWhereANetworkAnswersNoNumber) {
  const std::string path =
      (std::filesystem::path(testing::TempDir()) / "arena-position-test.txt").string();
  const auto evaluator = std::make_shared<FailingEvaluator>(/*good_batches=*/20);
  const ModelLoader loader = [&](const std::string&) -> Model { return {evaluator, 1}; };
  MatchSettings settings{.games = 1000, .threads = 1};
  settings.position_file = path;
  try {
    (void)PlayQuietly(LineupOf("raw:model=broken", "idle"), settings, loader);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("agent raw:model=broken: evaluator failing answered"));
    EXPECT_THAT(error.what(), HasSubstr("nan"));
    EXPECT_THAT(error.what(), HasSubstr("the position is saved in " + path));
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
  EXPECT_EQ(ToText(FromText(TextOf(path))), evaluator->asked);
  std::filesystem::remove(path);
}

// The others do not play on for hours, and one of them tells.
TEST(Match, StopsAllThreadsForTheErrorOfOne) {
  const ModelLoader loader = [](const std::string&) -> Model {
    return {std::make_shared<FailingEvaluator>(/*good_batches=*/3), 1};
  };
  MatchSettings settings{.games = 1'000'000, .threads = 4};
  settings.position_file = "/absent/position.txt";
  try {
    (void)PlayQuietly(LineupOf("search:simulations=2,model=broken", "idle"), settings, loader);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("could not be saved in /absent/position.txt"));
  }
}

TEST(Match, EndsWhereTheObserverHasEnoughWhateverTheThreads) {
  const MatchLineup lineup = LineupOf("search:simulations=2", "simple_unbiased");
  for (const int threads : {1, 4}) {
    MatchPlayer player(lineup, {.games = 200, .threads = threads, .games_in_flight = 3}, kNoModels);
    std::vector<int> seen;
    player.Play(200, {.on_game = [](const PlayedGame&) {},
                      .is_enough =
                          [&](const PlayedGame& game) {
                            seen.push_back(game.number);
                            return game.number == 6;
                          }});
    EXPECT_EQ(seen, (std::vector<int>{0, 1, 2, 3, 4, 5, 6})) << threads;
    const std::vector<std::array<int, 3>> figures = FiguresOf(player.match());
    EXPECT_EQ(figures, FiguresOf(PlayQuietly(lineup, {.games = 7}))) << threads;
    // Games cut off are in the time, and so their moves are counted with it.
    std::uint64_t moves = 0;
    for (const PlayedGame& game : player.match().games) moves += game.statistics[0].moves;
    EXPECT_GE(player.match().timed_moves, moves);
  }
}

TEST(Match, GoesOnWhereItPaused) {
  const MatchLineup lineup = LineupOf("random", "simple_unbiased");
  const MatchObserver quiet{.on_game = [](const PlayedGame&) {}, .is_enough = nullptr};
  MatchPlayer player(lineup, {.games = 20}, kNoModels);
  player.Play(5, quiet);
  player.Play(15, quiet);
  EXPECT_EQ(FiguresOf(player.match()), FiguresOf(PlayQuietly(lineup, {.games = 20})));
  player.KeepFirst(3);
  EXPECT_EQ(player.match().games.size(), 3u);
}

TEST(Match, MeasuresAnAgentWithItselfAsMateInBothSeats) {
  MatchSettings settings{.game = GameSettingsFor("PommeTeamCompetition-v0").value(), .games = 2};
  MatchLineup lineup = LineupOf("random", "idle");
  EXPECT_EQ(PlayQuietly(lineup, settings).roles, std::vector<int>{0});
  lineup[2] = lineup[0];
  EXPECT_EQ(PlayQuietly(lineup, settings).roles, (std::vector<int>{0, 2}));
  settings.game = {};
  EXPECT_EQ(PlayQuietly(lineup, settings).roles, std::vector<int>{0});
}

ContestSettings ContestOf(int games, const std::string& question = "", int min_games = 1) {
  ContestSettings settings;
  settings.match.games = games;
  if (!question.empty()) settings.question = ParseQuestion(question);
  settings.min_games = min_games;
  return settings;
}

// Writes down who was told what.
class Notes final : public ContestWatcher {
 public:
  void Began(int agent) override { turns.push_back(agent); }
  void Played(int agent, const PlayedGame&) override { ++games[agent]; }
  void Tested(int agent, const TestState& state) override {
    EXPECT_EQ(state.games, ++tests[agent]);
  }
  void Paused(int agent) override { EXPECT_EQ(agent, turns.back()); }

  std::vector<int> turns;
  std::map<int, int> games;
  std::map<int, std::uint64_t> tests;
};

TEST(Contest, PlaysEveryAgentOnTheSameBoards) {
  Notes notes;
  const std::vector<MatchLineup> lineups = {LineupOf("idle", "random"),
                                            LineupOf("random", "random")};
  const auto results = PlayContest(lineups, ContestOf(8), kNoModels, notes);
  ASSERT_EQ(results.size(), 2u);
  for (int game = 0; game < 8; ++game) {
    EXPECT_EQ(results[0].match.games[game].seed, results[1].match.games[game].seed);
  }
  EXPECT_EQ(results[0].test, std::nullopt);
  EXPECT_EQ(notes.turns, (std::vector<int>{0, 1}));
  EXPECT_EQ(notes.games, (std::map<int, int>{{0, 8}, {1, 8}}));
}

TEST(Contest, AnswersAWinRateForEachAgentOnItsOwn) {
  Notes notes;
  const std::vector<MatchLineup> lineups = {LineupOf("simple_unbiased", "idle"),
                                            LineupOf("idle", "simple_unbiased")};
  ContestSettings settings = ContestOf(5000, "win_rate=0.3..0.6", 10);
  settings.match.threads = 2;
  const auto results = PlayContest(lineups, settings, kNoModels, notes);
  EXPECT_EQ(results[0].test->answer, Answer::kHigh);
  EXPECT_EQ(results[1].test->answer, Answer::kLow);
  for (const ContestResult& result : results) {
    EXPECT_EQ(result.match.games.size(), result.test->games);
    EXPECT_LT(result.test->games, 100u);
    EXPECT_GE(result.test->games, 10u);
  }
  settings.match.threads = 1;
  settings.match.games_in_flight = 1;
  Notes others;
  EXPECT_EQ(PlayContest(lineups, settings, kNoModels, others)[0].test->games,
            results[0].test->games);
}

TEST(Contest, AnswersAScoreDifferenceWithTheTwoTakingTurns) {
  Notes notes;
  const std::vector<MatchLineup> lineups = {LineupOf("simple_unbiased", "simple_unbiased"),
                                            LineupOf("random", "simple_unbiased")};
  const ContestSettings settings = ContestOf(5000, "score_difference=-0.2..0", 30);
  const auto results = PlayContest(lineups, settings, kNoModels, notes);
  EXPECT_EQ(results[0].test, std::nullopt);
  EXPECT_EQ(results[1].test->answer, Answer::kLow);
  EXPECT_EQ(results[0].match.games.size(), results[1].match.games.size());
  EXPECT_EQ(results[1].match.games.size(), results[1].test->games);
  EXPECT_EQ(notes.turns[0], 0);
  EXPECT_EQ(notes.turns[1], 1);
}

TEST(Contest, LeavesAQuestionOpenAfterTheLastGame) {
  Notes notes;
  const std::vector<MatchLineup> lineups = {LineupOf("random", "random"),
                                            LineupOf("random", "random")};
  const ContestSettings settings = ContestOf(60, "score_difference=0..0.01", 20);
  const auto results = PlayContest(lineups, settings, kNoModels, notes);
  EXPECT_EQ(results[1].test->answer, Answer::kOpen);
  EXPECT_EQ(results[1].test->games, 60u);
  EXPECT_EQ(results[0].match.games.size(), 60u);
}

TEST(Contest, RefusesAScoreDifferenceOfOneAgent) {
  Notes notes;
  const std::vector<MatchLineup> lineups = {LineupOf("random", "random")};
  const ContestSettings settings = ContestOf(5, "score_difference=0..0.01");
  EXPECT_THROW((void)PlayContest(lineups, settings, kNoModels, notes), Error);
}

}  // namespace
}  // namespace powderkeg

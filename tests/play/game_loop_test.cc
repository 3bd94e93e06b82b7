#include "actors/play/game_loop.h"

#include <gtest/gtest.h>

#include "tests/play/support.h"
#include "tests/search/settings_from_text.h"

namespace powderkeg {
namespace {

std::vector<GameRecord> PlaySearchedGames(std::size_t games, int games_in_flight) {
  SearchSettings settings = ParseSearchSettings("simulations=8");
  SearchHost host(games, settings);
  GameLoop loop(host, GameSettings(), games_in_flight);
  while (loop.RunRound()) {
  }
  return host.records;
}

TEST(GameLoop, SearchedGamesAreTheSameAloneAndAmongSixtyFour) {
  const std::vector<GameRecord> alone = PlaySearchedGames(/*games=*/12, /*games_in_flight=*/1);
  EXPECT_EQ(alone, PlaySearchedGames(/*games=*/12, /*games_in_flight=*/64));
  EXPECT_EQ(alone, PlaySearchedGames(/*games=*/12, /*games_in_flight=*/5));
}

TEST(GameLoop, SearchedGamesPassVerify) {
  for (const GameRecord& record : PlaySearchedGames(/*games=*/8, /*games_in_flight=*/3)) {
    EXPECT_EQ(Verify(record), std::nullopt) << "ticket " << record.ticket;
    EXPECT_GT(DecisionCount(record), 0u);
  }
}

// One asking agent per slot; the other seats stand idle, so that a game lasts until its death.
class AskingHost final : public ListHost {
 public:
  AskingHost(std::size_t games, int slots) : ListHost(games) {
    for (int slot = 0; slot < slots; ++slot) agents_.emplace_back(/*questions=*/2);
  }
  GamePlan PlanOf(int slot, std::uint64_t ticket) override {
    GamePlan plan;
    plan.setup = SetupOfSeats({kSearching, {}, {}, {}}, ticket);
    plan.agents[0] = {&agents_[static_cast<std::size_t>(slot)], model, /*takes_new_weights=*/true};
    return plan;
  }

  std::shared_ptr<ConstantEvaluator> evaluator = std::make_shared<ConstantEvaluator>(0.5F);
  Model model{evaluator, /*weights_version=*/1};

 private:
  std::vector<AskingAgent> agents_;
};

TEST(GameLoop, FillsBatchesAcrossGames) {
  AskingHost host(/*games=*/4, /*slots=*/4);
  GameLoop loop(host, GameSettings(), /*games_in_flight=*/4);
  ASSERT_TRUE(loop.RunRound());
  EXPECT_EQ(loop.games_running(), 4);
  EXPECT_EQ(loop.metrics().batches, 1u);
  EXPECT_EQ(loop.metrics().evaluations, 4u);
  EXPECT_EQ(loop.metrics().mean_batch(), 4.0);
}

TEST(GameLoop, CountsWhatItPlayed) {
  AskingHost host(/*games=*/9, /*slots=*/4);
  GameLoop loop(host, GameSettings(), /*games_in_flight=*/4);
  while (loop.RunRound()) {
  }
  std::uint64_t steps = 0;
  std::uint64_t decisions = 0;
  for (const GameRecord& record : host.records) {
    steps += record.actions.size();
    decisions += DecisionCount(record);
  }
  EXPECT_EQ(loop.games_running(), 0);
  EXPECT_EQ(loop.metrics().games, 9u);
  EXPECT_EQ(loop.metrics().steps, steps);
  EXPECT_EQ(loop.metrics().decisions, decisions);
  EXPECT_EQ(loop.metrics().evaluations, 2 * decisions);
  EXPECT_EQ(loop.metrics().batches, static_cast<std::uint64_t>(host.evaluator->batches));
}

TEST(GameLoop, PausesWhereTheHostHasNoGameAndGoesOnWhenItHas) {
  class PausingHost final : public GameHost {
   public:
    std::optional<GamePlan> NextGame(int slot) override {
      return open ? std::optional(games.PlanOf(slot, 0)) : std::nullopt;
    }
    void GameFinished(int /*slot*/, Game& /*game*/) override { ++finished; }
    AskingHost games{/*games=*/1, /*slots=*/1};
    bool open = false;
    int finished = 0;
  };
  PausingHost host;
  GameLoop loop(host, GameSettings(), /*games_in_flight=*/1);
  EXPECT_FALSE(loop.RunRound());
  host.open = true;
  EXPECT_TRUE(loop.RunRound());
  host.open = false;
  while (loop.RunRound()) {
  }
  EXPECT_EQ(host.finished, 1);
}

TEST(GameLoop, OldAndNewWeightsAnswerSideBySide) {
  AskingHost host(/*games=*/8, /*slots=*/2);
  GameLoop loop(host, GameSettings(), /*games_in_flight=*/2);
  ASSERT_TRUE(loop.RunRound());
  host.model = {std::make_shared<ConstantEvaluator>(-0.5F), /*weights_version=*/2};
  while (loop.RunRound()) {
  }
  for (const GameRecord& record : host.records) {
    const Track& track = record.tracks[0];
    EXPECT_EQ(track.weights_version, record.ticket < 2 ? 1u : 2u);
    for (const Decision& decision : track.decisions) {
      EXPECT_EQ(decision.weights_version, track.weights_version);
      EXPECT_EQ(decision.value, record.ticket < 2 ? 0.5F : -0.5F);
    }
  }
}

TEST(GameLoop, SetModelReachesRunningGames) {
  AskingHost host(/*games=*/1, /*slots=*/1);
  GameLoop loop(host, GameSettings(), /*games_in_flight=*/1);
  ASSERT_TRUE(loop.RunRound());
  loop.SetModel({std::make_shared<ConstantEvaluator>(-0.5F), /*weights_version=*/2});
  while (loop.RunRound()) {
  }
  EXPECT_EQ(host.records[0].tracks[0].weights_version, 1u);
  EXPECT_EQ(host.records[0].tracks[0].decisions.back().weights_version, 2u);
}

TEST(EvaluationBatches, ForgetsEvaluatorsThatNobodyAskedAndKeepsTheOthers) {
  EvaluationBatches batches;
  const State state;
  ConstantEvaluator first(0.25F);
  ConstantEvaluator second(0.75F);
  batches.For(first).Add({&state, 0});
  (void)batches.For(second);
  EXPECT_EQ(batches.size(), 1u);
  EXPECT_EQ(batches.Evaluate(GameSettings()), 1);
  EXPECT_EQ(batches.For(first).evaluation(0).value, 0.25F);
  EXPECT_EQ(second.batches, 0);
  batches.Clear();
  EXPECT_EQ(batches.size(), 0u);
  EXPECT_EQ(batches.Evaluate(GameSettings()), 0);
}

}  // namespace
}  // namespace powderkeg

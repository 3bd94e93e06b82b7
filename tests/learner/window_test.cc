#include "learner/replay/window.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "common/base/check.h"
#include "learner/replay/samples.h"
#include "tests/learner/played_games.h"

namespace powderkeg {
namespace {

// Samples that can be told apart by their step.
std::vector<Sample> Numbered(int first, int count) {
  std::vector<Sample> samples;
  for (int i = 0; i < count; ++i) {
    samples.emplace_back().state.step = static_cast<std::uint16_t>(first + i);
  }
  return samples;
}

std::vector<int> StepsIn(const ReplayWindow& window) {
  std::vector<int> steps;
  for (std::size_t i = 0; i < window.size(); ++i) steps.push_back(window[i].state.step);
  return steps;
}

TEST(Samples, AGameGivesItsDecisionsAsTheViewerMaySeeThem) {
  const GameRecord game = PlayGame(3);
  DataSet data_set;
  AddGame(game, data_set);
  ASSERT_EQ(data_set.samples.size(), game.decisions.size());
  for (std::size_t i = 0; i < game.decisions.size(); ++i) {
    const Sample& sample = data_set.samples[i];
    EXPECT_EQ(sample.visits, game.decisions[i].visits);
    EXPECT_EQ(sample.state.step, game.decisions[i].step);
    EXPECT_EQ(sample.viewer, 0);
    EXPECT_EQ(sample.outcome, OutcomeFor(game, 0));
    EXPECT_TRUE(sample.state.HiddenItems().Empty());
  }
}

TEST(Samples, TheSummaryCountsGamesResultsAndActions) {
  const std::vector<GameRecord> games = {PlayGame(0, /*weights_version=*/0), PlayGame(1, 4)};
  DataSet data_set;
  for (const GameRecord& game : games) AddGame(game, data_set);
  const PlaySummary& summary = data_set.summary;
  EXPECT_EQ(summary.games, 2u);
  EXPECT_EQ(summary.decisions, games[0].decisions.size() + games[1].decisions.size());
  EXPECT_EQ(summary.steps, games[0].actions.size() + games[1].actions.size());
  EXPECT_EQ(summary.score.games(), 2u);
  EXPECT_EQ(summary.weights_versions, 1u + 4u) << "0, no network, counts as 1";
  EXPECT_EQ(std::accumulate(summary.actions.begin(), summary.actions.end(), std::uint64_t{0}),
            summary.decisions);
}

TEST(Samples, AGameThatDoesNotVerifyIsAnErrorWithItsTicket) {
  GameRecord game = PlayGame(5);
  game.actions[0][1] = game.actions[0][1] == Action::kStop ? Action::kBomb : Action::kStop;
  DataSet data_set;
  try {
    AddGame(game, data_set);
    FAIL() << "expected an error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("ticket 5"));
  }
}

TEST(ReplayWindow, KeepsTheLastDataSets) {
  ReplayWindow window(2, 1 << 30);
  EXPECT_EQ(window.size(), 0u);
  window.Push(Numbered(0, 3));
  window.Push(Numbered(10, 2));
  EXPECT_THAT(StepsIn(window), testing::ElementsAre(0, 1, 2, 10, 11));
  window.Push(Numbered(20, 1));
  EXPECT_THAT(StepsIn(window), testing::ElementsAre(10, 11, 20));
  EXPECT_EQ(window.bytes(), 3 * sizeof(Sample));
}

TEST(ReplayWindow, KeepsWithinItsBudgetButAlwaysTheNewest) {
  ReplayWindow window(10, 5 * sizeof(Sample));
  window.Push(Numbered(0, 3));
  window.Push(Numbered(10, 2));
  EXPECT_THAT(StepsIn(window), testing::ElementsAre(0, 1, 2, 10, 11));
  window.Push(Numbered(20, 1));
  EXPECT_THAT(StepsIn(window), testing::ElementsAre(10, 11, 20));
  window.Push(Numbered(30, 9));
  EXPECT_THAT(StepsIn(window), testing::ElementsAre(30, 31, 32, 33, 34, 35, 36, 37, 38));
}

TEST(ReplayWindow, AnEmptyDataSetHoldsNoPlace) {
  ReplayWindow window(3, 1 << 30);
  window.Push(Numbered(0, 2));
  window.Push({});
  window.Push(Numbered(5, 1));
  EXPECT_THAT(StepsIn(window), testing::ElementsAre(0, 1, 5));
}

TEST(ReplayWindow, ShuffledOrderIsAPermutationThatFollowsTheGenerator) {
  ReplayWindow window(2, 1 << 30);
  window.Push(Numbered(0, 50));
  Rng rng(1);
  const auto first = window.ShuffledOrder(rng);
  EXPECT_EQ(std::set(first.begin(), first.end()).size(), 50u);
  EXPECT_NE(window.ShuffledOrder(rng), first);
  Rng again(1);
  EXPECT_EQ(window.ShuffledOrder(again), first);
}

}  // namespace
}  // namespace powderkeg

#include "actors/search/root_policy.h"

#include <gtest/gtest.h>

#include <numeric>

namespace powderkeg {
namespace {

constexpr RootStatistics kRoot = {.visits = {10, 60, 0, 20, 10, 0},
                                  .values = {0.1F, 0.2F, 0, 0.7F, -0.5F, 0},
                                  .priors = {0.2F, 0.1F, 0, 0.4F, 0.1F, 0.2F}};

TEST(RootPolicy, PlaysTheMostVisitedAction) {
  EXPECT_EQ(ChooseMove({}, kRoot, Rng(1)), Action::kUp);
}

TEST(RootPolicy, WithoutExplorationNothingIsLeftToChance) {
  SearchSettings settings;
  settings.simulations = 64;
  settings.noise_weight = settings.gumbel_scale = settings.temperature = 0.5;
  settings.exploratory_start = settings.forced_playouts = settings.full_search_share = 0.5;
  SearchSettings expected;
  expected.simulations = 64;
  expected.noise_weight = expected.gumbel_scale = 0;
  EXPECT_EQ(WithoutExploration(settings), expected);
}

TEST(RootPolicy, EqualVisitsGoToTheMoreValuableAction) {
  RootStatistics root = kRoot;
  root.visits[3] = 60;
  EXPECT_EQ(ChooseMove({}, root, Rng(1)), Action::kLeft);
  root.values[3] = root.values[1];
  EXPECT_EQ(ChooseMove({}, root, Rng(1)), Action::kUp);
}

TEST(RootPolicy, WithoutVisitsThePriorDecides) {
  RootStatistics root = kRoot;
  root.visits.fill(0);
  EXPECT_EQ(ChooseMove({}, root, Rng(1)), Action::kLeft);
}

TEST(RootPolicy, VetoPrefersAClearlyBetterValue) {
  SearchSettings settings;
  settings.q_veto = 0.4;
  EXPECT_EQ(ChooseMove(settings, kRoot, Rng(1)), Action::kLeft);
  settings.q_veto = 0.6;
  EXPECT_EQ(ChooseMove(settings, kRoot, Rng(1)), Action::kUp);
}

TEST(RootPolicy, QWeightMixesValuesIn) {
  SearchSettings settings;
  settings.q_weight = 1;
  EXPECT_EQ(ChooseMove(settings, kRoot, Rng(1)), Action::kLeft);
}

TEST(RootPolicy, TemperatureOneDrawsByVisits) {
  SearchSettings settings;
  settings.temperature = 1;
  std::array<int, kActionCount> counts{};
  for (std::uint64_t seed = 0; seed < 10000; ++seed) {
    ++counts[static_cast<std::size_t>(ChooseMove(settings, kRoot, Rng(seed)))];
  }
  for (std::size_t a = 0; a < kActionCount; ++a) {
    EXPECT_NEAR(counts[a], 100.0 * kRoot.visits[a], 200) << "action " << a;
  }
  EXPECT_EQ(counts[2] + counts[5], 0);
}

TEST(RootPolicy, NoiseIsSpreadOverLegalActions) {
  SearchSettings settings;
  settings.noise_weight = 0.25;
  Rng rng(3);
  constexpr std::array<float, kActionCount> kPriors = {0.5F, 0.25F, 0, 0.25F, 0, 0};
  std::array<double, kActionCount> sums{};
  constexpr int kDraws = 2000;
  for (int i = 0; i < kDraws; ++i) {
    const auto mixed = WithNoise(settings, kPriors, 0b001011, rng);
    EXPECT_NEAR(std::accumulate(mixed.begin(), mixed.end(), 0.0), 1.0, 1e-5);
    for (std::size_t a = 0; a < kActionCount; ++a) {
      EXPECT_GE(mixed[a], 0.75F * kPriors[a] - 1e-6F);
      sums[a] += static_cast<double>(mixed[a]);
    }
  }
  EXPECT_NEAR(sums[0] / kDraws, 0.75 * 0.5 + 0.25 / 3, 0.01);
  EXPECT_EQ(sums[2] + sums[4] + sums[5], 0);
}

TEST(RootPolicy, WithoutVisitsOnlyLegalActionsAreChosen) {
  RootStatistics root = kRoot;
  root.visits.fill(0);
  root.legal = 0b110110;
  EXPECT_EQ(ChooseMove({}, root, Rng(1)), Action::kBomb);
  root.priors.fill(0);
  EXPECT_EQ(ChooseMove({}, root, Rng(1)), Action::kUp);
}

// sqrt(2 P 100): 6.3, 4.5, -, 8.9, 4.5, -.
TEST(RootPolicy, ForcesTriedActionsToTheirShare) {
  RootStatistics root = kRoot;
  EXPECT_EQ(ForcedAction(/*k=*/2, root), kActionCount);
  root.visits = {10, 67, 0, 8, 10, 5};
  EXPECT_EQ(ForcedAction(2, root), 3U) << "8 visits are fewer than 8.9";
  root.visits = {6, 63, 0, 8, 10, 13};
  EXPECT_EQ(ForcedAction(2, root), 0U) << "the lowest";
  root.visits = {0, 90, 0, 10, 0, 0};
  EXPECT_EQ(ForcedAction(2, root), kActionCount) << "untried actions are not forced";
}

TEST(RootPolicy, ForcedVisitsAreNotLearned) {
  RootStatistics root;
  root.priors = {0.5F, 0.2F, 0.1F, 0.1F, 0.1F, 0};
  root.values = {0.5F, -0.9F, 0.45F, -0.9F, 0.4F, 0};
  root.visits = {80, 6, 4, 1, 9, 0};
  // Scores with exploration 10: best 0.5 + 5 / 81 = 0.56. Action 1 stays below it down to 1 visit
  // (-0.9 + 2 / 2), which goes too. Action 2 would be above it with 3 visits. 4 visits of action 4
  // (0.4 + 1 / 5) would be above it, 5 not (0.4 + 1 / 6 = 0.567 is), so it keeps 6.
  EXPECT_EQ(WithoutForced(/*k=*/2, /*exploration=*/10, root),
            (std::array<std::uint32_t, kActionCount>{80, 0, 4, 0, 6, 0}));
  EXPECT_EQ(WithoutForced(/*k=*/0, 10, root)[1], 6U);
}

}  // namespace
}  // namespace powderkeg

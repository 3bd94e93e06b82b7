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

}  // namespace
}  // namespace powderkeg

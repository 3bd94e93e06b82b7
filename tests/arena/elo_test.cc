#include "actors/arena/elo.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "common/base/rng.h"

namespace powderkeg {
namespace {

TEST(Elo, OfEqualSidesIsZero) {
  EXPECT_NEAR(EloFromPoints(0.5, 2), 0, 1e-9);
  EXPECT_NEAR(EloFromPoints(0.25, 4), 0, 1e-9);
  EXPECT_NEAR(EloOverOpponents({.wins = 20, .ties = 20, .losses = 60}, 4).elo, 0, 1e-9);
  EXPECT_NEAR(EloOverOpponents({.wins = 40, .ties = 20, .losses = 40}, 2).elo, 0, 1e-9);
}

// Strength 3 among 1, 1, 1 takes half of the points.
TEST(Elo, FollowsLucesChoice) {
  EXPECT_NEAR(EloFromPoints(0.5, 4), 400 * std::log10(3), 1e-9);
  EXPECT_NEAR(EloFromPoints(10.0 / 11, 2), 400, 1e-9);
  EXPECT_EQ(EloFromPoints(1, 4), INFINITY);
  EXPECT_EQ(EloFromPoints(0, 2), -INFINITY);
}

TEST(Elo, SharesThePointOfATie) {
  EXPECT_EQ(PointsFor(1, 4), 1);
  EXPECT_EQ(PointsFor(0, 4), 0.25);
  EXPECT_EQ(PointsFor(0, 2), 0.5);
  EXPECT_EQ(PointsFor(-1, 4), 0);
  EXPECT_EQ(SideCount(Mode::kFreeForAll), 4);
  EXPECT_EQ(SideCount(Mode::kTeamRadio), 2);
  EXPECT_EQ(SideCount(Mode::kOneVsOne), 2);
}

TEST(Elo, HasTheIntervalOfTheScore) {
  const EloEstimate estimate = EloOverOpponents({.wins = 15, .losses = 5}, 4);
  const Interval rate = WilsonInterval(15, 20);
  EXPECT_DOUBLE_EQ(estimate.elo, EloFromPoints(0.75, 4));
  EXPECT_DOUBLE_EQ(estimate.interval.low, EloFromPoints(rate.low, 4));
  EXPECT_DOUBLE_EQ(estimate.interval.high, EloFromPoints(rate.high, 4));
  const EloEstimate perfect = EloOverOpponents({.wins = 20}, 2);
  EXPECT_EQ(perfect.elo, INFINITY);
  EXPECT_EQ(perfect.interval.high, INFINITY);
  EXPECT_NEAR(perfect.interval.low, EloFromPoints(WilsonInterval(20, 20).low, 2), 1e-9);
  EXPECT_GT(perfect.interval.low, 200);
}

TEST(PairedElo, OfEqualResultsIsZeroWithoutDoubt) {
  const std::vector<double> points = {1, 0, 0.25, 1};
  const EloEstimate estimate = PairedElo(points, points, 4);
  EXPECT_EQ(estimate.elo, 0);
  EXPECT_NEAR(estimate.interval.low, 0, 1e-9);
  EXPECT_NEAR(estimate.interval.high, 0, 1e-9);
}

TEST(PairedElo, IsTheDifferenceOfBothWithADeltaInterval) {
  constexpr std::array<double, 4> points = {1, 1, 1, 0};
  constexpr std::array<double, 4> base = {1, 1, 0, 0};
  const EloEstimate estimate = PairedElo(points, base, 2);
  EXPECT_NEAR(estimate.elo, 400 * std::log10(3), 1e-9);
  // Linearised: 400 / ln 10 times points * 16 / 3 - base * 4.
  RunningStatistics differences;
  for (const double sample : {16.0 / 3 - 4, 16.0 / 3 - 4, 16.0 / 3, 0.0}) differences.Add(sample);
  const double radius = 400 / std::log(10) * kNormal95 * differences.standard_deviation() / 2;
  EXPECT_NEAR(estimate.interval.low, estimate.elo - radius, 1e-9);
  EXPECT_NEAR(estimate.interval.high, estimate.elo + radius, 1e-9);
}

TEST(PairedElo, KnowsNothingOfPerfectScores) {
  const EloEstimate estimate = PairedElo(std::vector<double>{1, 1}, std::vector<double>{1, 0}, 2);
  EXPECT_EQ(estimate.elo, INFINITY);
  EXPECT_EQ(estimate.interval, (Interval{-INFINITY, INFINITY}));
  EXPECT_EQ(PairedElo(std::vector<double>{1.0}, std::vector<double>{1.0}, 2).elo, 0);
}

// 95 % intervals hold the truth in about 95 % of matches whose games are correlated.
TEST(PairedElo, CoversTheTruth) {
  const double truth = EloFromPoints(0.5, 4) - EloFromPoints(0.4, 4);
  int covered = 0;
  for (int match = 0; match < 1000; ++match) {
    Rng rng = Rng(3).Split(static_cast<std::uint64_t>(match));
    std::vector<double> points;
    std::vector<double> base;
    for (int game = 0; game < 200; ++game) {
      const double board = rng.Uniform();
      const double luck = rng.Uniform() < 0.5 ? rng.Uniform() : board;
      points.push_back(board < 0.5 ? 1 : 0);
      base.push_back(luck < 0.4 ? 1 : 0);
    }
    const Interval interval = PairedElo(points, base, 4).interval;
    if (interval.low <= truth && truth <= interval.high) ++covered;
  }
  EXPECT_GT(covered, 930);
  EXPECT_LT(covered, 970);
}

}  // namespace
}  // namespace powderkeg

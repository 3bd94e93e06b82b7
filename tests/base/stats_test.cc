#include "common/base/stats.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace powderkeg {
namespace {

TEST(WilsonInterval, HasThePinnedEnds) {
  EXPECT_NEAR(WilsonInterval(62, 100).low, 0.5220975529551107, 1e-12);
  EXPECT_NEAR(WilsonInterval(62, 100).high, 0.7090240074752127, 1e-12);
  EXPECT_NEAR(WilsonInterval(310, 500).low, 0.576692489073785, 1e-12);
  EXPECT_NEAR(WilsonInterval(310, 500).high, 0.6614776692154425, 1e-12);
}

TEST(WilsonInterval, StaysWithinZeroAndOne) {
  EXPECT_EQ(WilsonInterval(0, 10).low, 0);
  EXPECT_NEAR(WilsonInterval(0, 10).high, 0.2775327998628892, 1e-12);
  EXPECT_EQ(WilsonInterval(10, 10).high, 1);
  EXPECT_EQ(WilsonInterval(0, 0), (Interval{0, 1}));
}

TEST(WilsonInterval, RefusesMoreSuccessesThanTrials) {
  EXPECT_DEATH((void)WilsonInterval(2, 1), "2 of 1");
}

TEST(RunningStatistics, MatchesTheTwoPassFormulas) {
  RunningStatistics statistics;
  for (const double sample : {2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0}) statistics.Add(sample);
  EXPECT_EQ(statistics.count(), 8u);
  EXPECT_DOUBLE_EQ(statistics.mean(), 5);
  EXPECT_DOUBLE_EQ(statistics.variance(), 32.0 / 7);
  EXPECT_NEAR(statistics.MeanInterval().high, 5 + 1.959963984540054 * std::sqrt(32.0 / 56), 1e-12);
}

TEST(RunningStatistics, SumsAsIfSamplesWereAddedToOne) {
  RunningStatistics whole;
  RunningStatistics first;
  RunningStatistics second;
  for (int i = 0; i < 10; ++i) {
    const double sample = 1e6 + i * i;
    whole.Add(sample);
    (i < 3 ? first : second).Add(sample);
  }
  first += second;
  first += RunningStatistics();
  EXPECT_EQ(first.count(), whole.count());
  EXPECT_DOUBLE_EQ(first.mean(), whole.mean());
  EXPECT_NEAR(first.variance(), whole.variance(), 1e-6);
}

TEST(RunningStatistics, IsZeroWhileEmpty) {
  EXPECT_EQ(RunningStatistics().mean(), 0);
  EXPECT_EQ(RunningStatistics().standard_deviation(), 0);
  EXPECT_EQ(RunningStatistics().MeanInterval(), Interval());
}

TEST(EloDifference, HasThePinnedValues) {
  const EloEstimate estimate = EloDifference({.wins = 60, .ties = 20, .losses = 40});
  EXPECT_NEAR(estimate.elo, 58.45121427129523, 1e-9);
  EXPECT_NEAR(estimate.interval.low, 2.112982571619796, 1e-9);
  EXPECT_NEAR(estimate.interval.high, 118.04029414498522, 1e-9);
}

TEST(EloDifference, OfAnEvenMatchIsZeroAndOfAPerfectOneInfinite) {
  EXPECT_EQ(EloDifference({.wins = 5, .ties = 3, .losses = 5}).elo, 0);
  EXPECT_TRUE(std::isinf(EloDifference({.wins = 5, .ties = 0, .losses = 0}).elo));
  EXPECT_NEAR(ScoreFromElo(EloFromScore(0.7)), 0.7, 1e-12);
}

TEST(Sprt, HasThePinnedRatioAndBounds) {
  const SprtResult result = Sprt({.wins = 60, .ties = 20, .losses = 40}, {});
  EXPECT_NEAR(result.log_likelihood_ratio, 0.652729047226289, 1e-9);
  EXPECT_NEAR(result.bounds.low, -2.9444389791664403, 1e-12);
  EXPECT_NEAR(result.bounds.high, 2.9444389791664403, 1e-12);
  EXPECT_EQ(result.verdict, SprtVerdict::kContinue);
}

TEST(Sprt, DecidesClearMatches) {
  EXPECT_EQ(Sprt({.wins = 700, .ties = 100, .losses = 200}, {}).verdict, SprtVerdict::kAcceptElo1);
  EXPECT_EQ(Sprt({.wins = 200, .ties = 100, .losses = 700}, {}).verdict, SprtVerdict::kAcceptElo0);
  EXPECT_EQ(Sprt({.wins = 5}, {}).log_likelihood_ratio, 0);
  EXPECT_EQ(Sprt({}, {}).verdict, SprtVerdict::kContinue);
}

TEST(ChiSquared, SumsSquaredDistances) {
  const std::vector<double> observed = {8, 12, 10};
  const std::vector<double> expected = {10, 10, 10};
  EXPECT_DOUBLE_EQ(ChiSquared(observed, expected), 0.8);
}

TEST(ChiSquaredTail, MatchesTablesAndClosedForms) {
  EXPECT_NEAR(ChiSquaredTail(3.841458820694124, 1), 0.05, 1e-12);
  EXPECT_NEAR(ChiSquaredTail(11.070497693516351, 5), 0.05, 1e-12);
  for (const double x : {0.1, 1.0, 5.0, 40.0}) {
    EXPECT_NEAR(ChiSquaredTail(x, 2), std::exp(-x / 2), 1e-13);
    EXPECT_NEAR(ChiSquaredTail(x, 4), std::exp(-x / 2) * (1 + x / 2), 1e-13);
  }
  EXPECT_EQ(ChiSquaredTail(0, 3), 1);
}

}  // namespace
}  // namespace powderkeg

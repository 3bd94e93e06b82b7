#include "common/base/stats.h"

#include <gtest/gtest.h>

#include <cmath>

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

TEST(EloFromScore, IsTheLogisticInverseAndInfiniteAtTheEnds) {
  EXPECT_EQ(EloFromScore(0.5), 0);
  EXPECT_NEAR(1 / (1 + std::pow(10, -EloFromScore(0.7) / 400)), 0.7, 1e-12);
  EXPECT_TRUE(std::isinf(EloFromScore(0)));
  EXPECT_TRUE(std::isinf(EloFromScore(1)));
}

}  // namespace
}  // namespace powderkeg

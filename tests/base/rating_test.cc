#include "common/base/rating.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace powderkeg {
namespace {

PairScore Pair(std::size_t first, std::size_t second, std::uint64_t wins, std::uint64_t losses,
               std::uint64_t ties = 0) {
  return {first, second, {.wins = wins, .ties = ties, .losses = losses}};
}

TEST(RatePlayers, FindsTheStrengthsThatMadeTheResults) {
  // Strengths 4, 2, 1: the first wins 2 of 3 games against the second, 4 of 5 against the third.
  const PairScore pairs[] = {Pair(0, 1, 20'000, 10'000), Pair(0, 2, 24'000, 6'000),
                             Pair(1, 2, 20'000, 10'000)};
  const auto ratings = RatePlayers(3, pairs);
  const double factor_two = 400 * std::log10(2.0);
  EXPECT_NEAR(ratings[0].elo, factor_two, 0.5);
  EXPECT_NEAR(ratings[1].elo, 0, 0.5);
  EXPECT_NEAR(ratings[2].elo, -factor_two, 0.5);
  EXPECT_LT(ratings[0].half_interval, 10);
}

TEST(RatePlayers, TiesAreHalvesAndNobodyIsInfinitelyStrong) {
  const PairScore tied[] = {Pair(0, 1, 0, 0, 50)};
  EXPECT_NEAR(RatePlayers(2, tied)[0].elo, 0, 1e-6);
  const PairScore crushed[] = {Pair(0, 1, 50, 0)};
  const auto ratings = RatePlayers(2, crushed);
  EXPECT_TRUE(std::isfinite(ratings[0].elo));
  EXPECT_GT(ratings[0].elo, 200);
}

TEST(RatePlayers, MoreGamesTellMore) {
  const PairScore few[] = {Pair(0, 1, 5, 5)};
  const PairScore many[] = {Pair(0, 1, 500, 500)};
  EXPECT_NEAR(RatePlayers(2, few)[0].half_interval / RatePlayers(2, many)[0].half_interval, 10,
              0.1);
  EXPECT_EQ(RatePlayers(1, {})[0].half_interval, std::numeric_limits<double>::infinity());
}

TEST(Place, WhoeverWonIsBeforeWhoeverLasted) {
  EXPECT_EQ(Compare({.won = true, .lasted = 10}, {.won = false, .lasted = 90}), 1);
  EXPECT_EQ(Compare({.lasted = 10}, {.lasted = 90}), -1);
  EXPECT_EQ(Compare({.lasted = 90}, {.lasted = 90}), 0);
}

TEST(RateNames, OrdersEverybodyAndCountsItsGames) {
  const auto rated = RateNames({{{"a", "b"}, {.wins = 2, .ties = 1, .losses = 7}},
                                {{"b", "c"}, {.wins = 9, .ties = 0, .losses = 1}},
                                {{"a", "c"}, {.wins = 6, .ties = 0, .losses = 4}}});
  ASSERT_EQ(rated.size(), 3u);
  EXPECT_EQ(rated[0].name, "b");
  EXPECT_EQ(rated[1].name, "a");
  EXPECT_EQ(rated[2].name, "c");
  EXPECT_EQ(rated[0].games, 20u);
  EXPECT_TRUE(RateNames({}).empty());
}

}  // namespace
}  // namespace powderkeg

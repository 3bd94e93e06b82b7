#include "common/base/nearest_name.h"

#include <gtest/gtest.h>

#include <array>
#include <string>

namespace powderkeg {
namespace {

constexpr std::array<std::string_view, 4> kKnown = {"idle", "simulations", "simple_unbiased",
                                                    "simulated_opponent"};

TEST(NearestName, NeedsTheFewestChanges) {
  EXPECT_EQ(NearestName("simulatons", kKnown), "simulations");
  EXPECT_EQ(NearestName("simulation_s", kKnown), "simulations");
  EXPECT_EQ(NearestName("simulated_oponnent", kKnown), "simulated_opponent");
  EXPECT_EQ(NearestName("idel", kKnown), "idle");
  EXPECT_EQ(NearestName("idle", kKnown), "idle");
}

TEST(NearestName, IsOneThatWasBegun) {
  EXPECT_EQ(NearestName("simple", kKnown), "simple_unbiased");
  EXPECT_EQ(NearestName("i", kKnown), "");
}

TEST(NearestName, IsNoneWhereNoneIsNear) {
  EXPECT_EQ(NearestName("nobody", kKnown), "");
  EXPECT_EQ(NearestName("", kKnown), "");
  EXPECT_EQ(NearestName(std::string(100'000, 's'), kKnown), "");
  EXPECT_EQ(NearestName("idle", {}), "");
}

TEST(DidYouMean, AsksOrSaysNothing) {
  EXPECT_EQ(DidYouMean("idel", kKnown), "; did you mean idle?");
  EXPECT_EQ(DidYouMean("nobody", kKnown), "");
}

}  // namespace
}  // namespace powderkeg

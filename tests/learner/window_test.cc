#include "learner/replay/window.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "common/base/check.h"
#include "learner/replay/lessons.h"

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

#include "common/base/bounded_queue.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>

namespace powderkeg {
namespace {

using std::chrono::milliseconds;

TEST(BoundedQueueTest, GivesValuesInOrder) {
  BoundedQueue<int> queue(3);
  for (int value : {1, 2, 3}) EXPECT_EQ(queue.TryPush(std::move(value)), QueueResult::kOk);
  EXPECT_EQ(queue.Pop(milliseconds(0)), 1);
  EXPECT_EQ(queue.Pop(milliseconds(0)), 2);
  EXPECT_EQ(queue.Pop(milliseconds(0)), 3);
  EXPECT_EQ(queue.Pop(milliseconds(0)), std::nullopt);
}

TEST(BoundedQueueTest, KeepsTheValueOfAPushThatFoundNoRoom) {
  BoundedQueue<std::unique_ptr<int>> queue(1);
  EXPECT_EQ(queue.TryPush(std::make_unique<int>(1)), QueueResult::kOk);
  auto second = std::make_unique<int>(2);
  EXPECT_EQ(queue.Push(std::move(second), milliseconds(1)), QueueResult::kTimedOut);
  ASSERT_NE(second, nullptr);
  EXPECT_EQ(*second, 2);
}

TEST(BoundedQueueTest, CloseRefusesPushesAndLetsTheRestOut) {
  BoundedQueue<int> queue(2);
  EXPECT_EQ(queue.TryPush(7), QueueResult::kOk);
  queue.Close();
  EXPECT_EQ(queue.TryPush(8), QueueResult::kClosed);
  EXPECT_FALSE(queue.drained());
  EXPECT_EQ(queue.Pop(milliseconds(0)), 7);
  EXPECT_TRUE(queue.drained());
}

TEST(BoundedQueueTest, CloseWakesAWaitingConsumer) {
  BoundedQueue<int> queue(1);
  std::jthread consumer([&] { EXPECT_EQ(queue.Pop(milliseconds(60'000)), std::nullopt); });
  queue.Close();
}

TEST(BoundedQueueTest, PassesEverythingBetweenThreads) {
  constexpr int kCount = 2000;
  BoundedQueue<int> queue(8);
  long sum = 0;
  std::jthread producer([&] {
    for (int i = 1; i <= kCount; ++i) {
      int value = i;
      EXPECT_EQ(queue.Push(std::move(value), milliseconds(60'000)), QueueResult::kOk);
    }
    queue.Close();
  });
  while (!queue.drained()) {
    if (const auto value = queue.Pop(milliseconds(100))) sum += *value;
  }
  EXPECT_EQ(sum, static_cast<long>(kCount) * (kCount + 1) / 2);
}

}  // namespace
}  // namespace powderkeg

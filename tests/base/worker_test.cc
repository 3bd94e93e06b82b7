#include "common/base/worker.h"

#include <gtest/gtest.h>

#include <condition_variable>
#include <mutex>

#include "common/base/check.h"

namespace powderkeg {
namespace {

TEST(WorkerTest, JoinRethrowsTheError) {
  Worker worker("fails", [](const std::stop_token&) { throw Error("disk full"); });
  try {
    worker.Join();
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "disk full");
  }
  EXPECT_TRUE(worker.finished());
  worker.Join();  // only the first time
}

TEST(WorkerTest, StopsWhenAsked) {
  std::mutex mutex;
  std::condition_variable_any changed;
  Worker worker("waits", [&](const std::stop_token& stop) {
    std::unique_lock lock(mutex);
    changed.wait(lock, stop, [] { return false; });
  });
  EXPECT_FALSE(worker.finished());
  worker.RequestStop();
  worker.Join();
  EXPECT_TRUE(worker.finished());
}

TEST(WorkerTest, DestructionStopsAndJoins) {
  bool ended = false;
  {
    const Worker worker("waits", [&](const std::stop_token& stop) {
      std::mutex mutex;
      std::condition_variable_any changed;
      std::unique_lock lock(mutex);
      changed.wait(lock, stop, [] { return false; });
      ended = true;
    });
  }
  EXPECT_TRUE(ended);
}

}  // namespace
}  // namespace powderkeg

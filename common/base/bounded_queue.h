#pragma once

// How threads hand values to each other one by one, without ever holding too many.

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

#include "common/base/check.h"

namespace powderkeg {

enum class QueueResult : std::uint8_t { kOk, kTimedOut, kClosed };

// First in, first out; at most `capacity` values. Thread-safe.
template <typename T>
class BoundedQueue {
 public:
  // Requires capacity > 0.
  explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) { CHECK(capacity > 0); }

  // Waits up to `timeout` for room. `value` is moved from only when the result is kOk.
  QueueResult Push(T&& value, std::chrono::milliseconds timeout) {
    std::unique_lock lock(mutex_);
    room_.wait_for(lock, timeout, [&] { return closed_ || values_.size() < capacity_; });
    if (closed_) return QueueResult::kClosed;
    if (values_.size() >= capacity_) return QueueResult::kTimedOut;
    values_.push_back(std::move(value));
    lock.unlock();
    filled_.notify_one();
    return QueueResult::kOk;
  }
  // Does not wait.
  QueueResult TryPush(T&& value) { return Push(std::move(value), std::chrono::milliseconds(0)); }

  // Waits up to `timeout` for a value. After Close the values that are left still come out;
  // nullopt: nothing came, or the queue is closed and empty.
  [[nodiscard]] std::optional<T> Pop(std::chrono::milliseconds timeout) {
    std::unique_lock lock(mutex_);
    filled_.wait_for(lock, timeout, [&] { return closed_ || !values_.empty(); });
    if (values_.empty()) return std::nullopt;
    std::optional<T> value(std::move(values_.front()));
    values_.pop_front();
    lock.unlock();
    room_.notify_one();
    return value;
  }

  // Wakes everybody; from now on Push is refused. May be called more than once.
  void Close() {
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
    }
    filled_.notify_all();
    room_.notify_all();
  }

  [[nodiscard]] bool closed() const {
    const std::lock_guard lock(mutex_);
    return closed_;
  }
  // Closed and nothing left: a consumer is done.
  [[nodiscard]] bool drained() const {
    const std::lock_guard lock(mutex_);
    return closed_ && values_.empty();
  }
  [[nodiscard]] std::size_t size() const {
    const std::lock_guard lock(mutex_);
    return values_.size();
  }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }

 private:
  const std::size_t capacity_;
  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable filled_;
  std::condition_variable room_;
  std::deque<T> values_;
  bool closed_ = false;
};

}  // namespace powderkeg

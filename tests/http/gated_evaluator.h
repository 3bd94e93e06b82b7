#pragma once

// An evaluator that a test holds up or lets fail.

#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <utility>

#include "common/model/evaluator.h"

namespace powderkeg {

// Answers uniformly. Thread-safe.
class GatedEvaluator final : public Evaluator {
 public:
  // Answers `calls` more times; the next call waits for Open.
  void CloseAfter(int calls) {
    const std::lock_guard lock(mutex_);
    until_closed_ = calls;
    open_ = false;
  }
  void Open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }
  // Returns when a call waits for Open.
  void AwaitCall() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return waiting_; });
  }
  // Answers `calls` more times; the next call throws (after it has waited), once.
  void FailAfter(int calls, std::exception_ptr failure) {
    const std::lock_guard lock(mutex_);
    until_failure_ = calls;
    failure_ = std::move(failure);
  }

  void Evaluate(const GameSettings& settings, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    std::unique_lock lock(mutex_);
    waiting_ = !open_ && until_closed_-- <= 0;
    if (waiting_) {
      changed_.notify_all();
      changed_.wait(lock, [this] { return open_; });
    }
    waiting_ = false;
    if (failure_ && until_failure_-- == 0) {
      std::rethrow_exception(std::exchange(failure_, nullptr));
    }
    UniformEvaluator().Evaluate(settings, positions, evaluations);
  }
  [[nodiscard]] std::string name() const override { return "gated"; }

 private:
  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  int until_closed_ = 0;
  int until_failure_ = 0;
  bool open_ = true;
  bool waiting_ = false;
  std::exception_ptr failure_;
};

}  // namespace powderkeg

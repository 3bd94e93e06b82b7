#include "actors/play/parallel_evaluator.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "common/base/check.h"

namespace powderkeg {
namespace {

using Clock = std::chrono::steady_clock;

// A search takes less than this from one batch to the next.
constexpr std::chrono::microseconds kSpin{200};

void Relax() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#else
  std::this_thread::yield();
#endif
}

// Returns when `word` is no longer `value`: at once while that happens within kSpin, else by
// sleeping.
void AwaitChange(const std::atomic<std::uint32_t>& word, std::uint32_t value) {
  constexpr int kLooksPerTime = 16;
  const Clock::time_point end = Clock::now() + kSpin;
  do {
    for (int i = 0; i < kLooksPerTime; ++i) {
      if (word.load(std::memory_order_acquire) != value) return;
      Relax();
    }
  } while (Clock::now() < end);
  word.wait(value, std::memory_order_acquire);
}

}  // namespace

ParallelEvaluator::ParallelEvaluator(std::vector<std::unique_ptr<Evaluator>> evaluators)
    : evaluators_(std::move(evaluators)) {
  CHECK(!evaluators_.empty());
  for (std::size_t i = 1; i < evaluators_.size(); ++i) {
    workers_.push_back(std::make_unique<Worker>(
        StrCat("evaluator ", i),
        [this, i](const std::stop_token& /*stop*/) { Serve(*evaluators_[i]); }));
  }
}

ParallelEvaluator::~ParallelEvaluator() {
  untaken_.store(kStop, std::memory_order_release);
  untaken_.notify_all();
}

void ParallelEvaluator::Evaluate(const GameSettings& settings, std::span<const Position> positions,
                                 std::span<Evaluation> evaluations) {
  CHECK(positions.size() == evaluations.size());
  const auto parts = static_cast<std::uint32_t>(std::min(positions.size(), evaluators_.size()));
  if (parts < 2) return evaluators_.front()->Evaluate(settings, positions, evaluations);
  job_ = {&settings, positions, evaluations, parts};
  unfinished_.store(parts, std::memory_order_relaxed);
  untaken_.store(parts, std::memory_order_release);
  untaken_.notify_all();
  TakeParts(*evaluators_.front());
  for (std::uint32_t left = 0; (left = unfinished_.load(std::memory_order_acquire)) > 0;) {
    AwaitChange(unfinished_, left);
  }
  const std::lock_guard lock(failure_mutex_);
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

std::string ParallelEvaluator::name() const {
  return StrCat(evaluators_.size(), " x ", evaluators_.front()->name());
}

void ParallelEvaluator::TakeParts(Evaluator& evaluator) {
  std::uint32_t untaken = untaken_.load(std::memory_order_acquire);
  while (untaken > 0 && untaken != kStop) {
    if (!untaken_.compare_exchange_weak(untaken, untaken - 1, std::memory_order_acq_rel,
                                        std::memory_order_acquire)) {
      continue;
    }
    Answer(untaken - 1, evaluator);
    if (unfinished_.fetch_sub(1, std::memory_order_acq_rel) == 1) unfinished_.notify_all();
    untaken = untaken_.load(std::memory_order_acquire);
  }
}

void ParallelEvaluator::Answer(std::uint32_t part, Evaluator& evaluator) {
  const std::size_t first = job_.positions.size() * part / job_.parts;
  const std::size_t end = job_.positions.size() * (part + 1) / job_.parts;
  try {
    evaluator.Evaluate(*job_.settings, job_.positions.subspan(first, end - first),
                       job_.evaluations.subspan(first, end - first));
  } catch (const std::exception&) {
    const std::lock_guard lock(failure_mutex_);
    if (!failure_) failure_ = std::current_exception();
  }
}

void ParallelEvaluator::Serve(Evaluator& evaluator) {
  for (;;) {
    const std::uint32_t untaken = untaken_.load(std::memory_order_acquire);
    if (untaken == kStop) return;
    untaken > 0 ? TakeParts(evaluator) : AwaitChange(untaken_, 0);
  }
}

}  // namespace powderkeg

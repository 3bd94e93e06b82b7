#pragma once

// Several cores for the questions of one game.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "common/base/worker.h"
#include "common/model/evaluator.h"

namespace powderkeg {

// Answers the parts of one batch at the same time, each with an evaluator of its own: the calling
// thread takes part, the other evaluators have a thread each. Parts differ in size by at most one.
// Whoever is free takes the next part, so that a thread that waits for a core holds nobody up. A
// thread without work looks for more during kSpin, then sleeps. An exception reaches the caller
// when all parts have ended; of several, the first. One calling thread at a time.
class ParallelEvaluator final : public Evaluator {
 public:
  // At least one evaluator; all must give the same answers.
  explicit ParallelEvaluator(std::vector<std::unique_ptr<Evaluator>> evaluators);
  ~ParallelEvaluator() override;
  ParallelEvaluator(const ParallelEvaluator&) = delete;
  ParallelEvaluator& operator=(const ParallelEvaluator&) = delete;

  void Evaluate(const GameSettings& settings, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override;
  // "2 x onednn bf16"
  [[nodiscard]] std::string name() const override;

 private:
  // The batch being answered. Written while no part of it is out, read by whoever took a part.
  struct Job {
    const GameSettings* settings = nullptr;
    std::span<const Position> positions;
    std::span<Evaluation> evaluations;
    std::uint32_t parts = 0;
  };
  static constexpr std::uint32_t kStop = ~std::uint32_t{0};  // value of untaken_: the end

  // Answers parts until none is left to be taken.
  void TakeParts(Evaluator& evaluator);
  void Answer(std::uint32_t part, Evaluator& evaluator);
  // A thread's life.
  void Serve(Evaluator& evaluator);

  std::vector<std::unique_ptr<Evaluator>> evaluators_;  // the first one is the caller's
  Job job_;
  std::atomic<std::uint32_t> untaken_ = 0;     // parts of the job that nobody took yet
  std::atomic<std::uint32_t> unfinished_ = 0;  // parts of the job without answers
  std::mutex failure_mutex_;
  std::exception_ptr failure_;                    // of a part of the job; guarded
  std::vector<std::unique_ptr<Worker>> workers_;  // last: they use the others
};

}  // namespace powderkeg

#pragma once

// Answers positions that were asked before from memory.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/model/evaluator.h"

namespace powderkeg {

// 128 bits that stand for a Position: every field of the state (unused bombs and padding left out),
// the viewer and the visible cells. Two positions that differ have equal keys with a probability of
// about 2^-128.
struct PositionKey {
  std::uint64_t low = 0;
  std::uint64_t high = 0;

  friend bool operator==(const PositionKey&, const PositionKey&) = default;
};
[[nodiscard]] PositionKey KeyOf(const Position& position);

// Wraps an evaluator: asks it only for positions that are not in the cache, and for one that occurs
// several times in a batch once. Evaluators that give the same answer whatever else is in the batch
// give the same answers through the cache. The memory is fixed; a full bucket replaces its oldest
// entry. One thread; the counters may be read from others.
class EvaluationCache final : public Evaluator {
 public:
  // Keeps at most `bytes` of answers (at least one bucket; 72 bytes an answer).
  EvaluationCache(std::unique_ptr<Evaluator> evaluator, std::size_t bytes);

  void Evaluate(const GameSettings& settings, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override;
  // "cached onednn bf16"
  [[nodiscard]] std::string name() const override;

  // Forgets all answers.
  void Clear();

  // Positions answered from memory (or with another of their batch) and by the evaluator since the
  // start.
  [[nodiscard]] std::uint64_t hits() const { return hits_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t misses() const { return misses_.load(std::memory_order_relaxed); }

 private:
  struct Entry {
    PositionKey key;
    Evaluation evaluation{};
    std::uint32_t stored_at = 0;  // value of clock_; empty if not after cleared_at_
  };
  // A position of the batch without a stored answer.
  struct Question {
    std::size_t position;  // in the batch
    std::size_t missing;   // which of those handed on answers it
  };
  static constexpr std::size_t kWays = 4;  // entries per bucket

  [[nodiscard]] std::span<Entry, kWays> BucketOf(const PositionKey& key);
  // The stored answer, or nullptr.
  [[nodiscard]] const Evaluation* Find(const PositionKey& key);
  void Store(const PositionKey& key, const Evaluation& evaluation);
  // Stored answers go to `evaluations`, everything else to the members below.
  void LookUp(std::span<const Position> positions, std::span<Evaluation> evaluations);
  // Which of the missing positions has this key; the number of them (where it then belongs) if none
  // has.
  [[nodiscard]] std::size_t FindMissing(const PositionKey& key);

  std::unique_ptr<Evaluator> evaluator_;
  GameSettings settings_;  // of all entries
  std::vector<Entry> entries_;
  std::uint32_t clock_ = 0;
  std::uint32_t cleared_at_ = 0;
  std::atomic<std::uint64_t> hits_ = 0;
  std::atomic<std::uint64_t> misses_ = 0;
  // What one Evaluate hands on; members keep their memory.
  std::vector<Question> questions_;
  std::vector<std::uint32_t>
      missing_by_key_;  // open addressing: index + 1 in what follows; 0: free
  std::vector<PositionKey> missing_keys_;
  std::vector<Position> missing_positions_;
  std::vector<Evaluation> missing_evaluations_;
};

}  // namespace powderkeg

#pragma once

// The seam between search and network: positions in, policies and values out, in batches.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"
#include "common/pommerman/step.h"

namespace powderkeg {

// One question: `state` as seen by `viewer`. The state must not hold more than the viewer may know
// (start from a Belief) and must stay in place until the answer was read.
struct Position {
  const State* state;
  AgentId viewer;
  BitBoard visible = BitBoard::All();  // cells outside are fog: all planes 0 there
};

// One answer, from the viewer's view.
struct Evaluation {
  std::array<float, kActionCount> policy;  // probabilities of all six actions, legal or not; sum 1
  float value;                             // expected outcome, -1 (loss) to +1 (win)
  // What viewer + 1, + 2, + 3 (mod 4) will do next: probabilities of all six actions in 255ths. All
  // 0 of the dead, of who stands in fog, and where the network foretells nobody.
  std::array<std::array<std::uint8_t, kActionCount>, kAgentCount - 1> others{};

  friend bool operator==(const Evaluation&, const Evaluation&) = default;
};

// A probability in Evaluation::others.
[[nodiscard]] constexpr std::uint8_t InWholes(float probability) {
  return static_cast<std::uint8_t>(probability * 255 + 0.5F);
}

// The action of `legal`, which has one, of the highest probability; ties go to the lowest.
[[nodiscard]] Action BestAction(std::span<const float, kActionCount> policy, ActionSet legal);
[[nodiscard]] Action BestAction(std::span<const std::uint8_t, kActionCount> policy,
                                ActionSet legal);

// Questions of many searches that are answered together. Slots are numbered in order of Add until
// Clear. One thread.
class EvaluationBatch {
 public:
  // Returns the slot of the answer.
  std::size_t Add(const Position& position) {
    positions_.push_back(position);
    return positions_.size() - 1;
  }
  // Forgets questions and answers; keeps the memory.
  void Clear() {
    positions_.clear();
    evaluations_.clear();
  }
  [[nodiscard]] std::size_t size() const { return positions_.size(); }
  [[nodiscard]] std::span<const Position> positions() const { return positions_; }
  // Room for the answers, one per position; for evaluators.
  [[nodiscard]] std::span<Evaluation> AllocateEvaluations() {
    evaluations_.resize(positions_.size());
    return evaluations_;
  }
  // Requires that the batch was evaluated since the last Add.
  [[nodiscard]] const Evaluation& evaluation(std::size_t slot) const { return evaluations_[slot]; }

 private:
  std::vector<Position> positions_;
  std::vector<Evaluation> evaluations_;
};

// Answers batches. Implementations: uniform (below), torch, onednn; wrappers add a cache. One
// thread per object.
class Evaluator {
 public:
  virtual ~Evaluator() = default;

  // Fills evaluations[i] for positions[i]; both have the same size, which may be 0. Blocks.
  virtual void Evaluate(const GameSettings& settings, std::span<const Position> positions,
                        std::span<Evaluation> evaluations) = 0;

  // For records and logs: "uniform", "torch cpu fp32", "onednn bf16".
  [[nodiscard]] virtual std::string name() const = 0;
};

// Policy 1/6 each, value 0: search without a network.
class UniformEvaluator final : public Evaluator {
 public:
  void Evaluate(const GameSettings& settings, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override;
  [[nodiscard]] std::string name() const override { return "uniform"; }
};

}  // namespace powderkeg

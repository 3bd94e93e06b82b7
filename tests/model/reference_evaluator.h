#pragma once

// The network as its description reads, in plain loops: slow, obvious, and what the fast evaluators
// must agree with.

#include <string>

#include "common/model/evaluator.h"
#include "common/model/weights_snapshot.h"

namespace powderkeg {

class ReferenceEvaluator final : public Evaluator {
 public:
  explicit ReferenceEvaluator(Snapshot snapshot) : snapshot_(std::move(snapshot)) {}

  void Evaluate(const GameSettings& settings, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override;
  [[nodiscard]] std::string name() const override { return "reference"; }

 private:
  Snapshot snapshot_;
};

}  // namespace powderkeg

#include <algorithm>

#include "common/model/evaluator.h"

namespace powderkeg {

void UniformEvaluator::Evaluate(const GameSettings& /*settings*/,
                                std::span<const Position> /*positions*/,
                                std::span<Evaluation> evaluations) {
  Evaluation uniform{};
  uniform.policy.fill(1.0F / kActionCount);
  std::ranges::fill(evaluations, uniform);
}

}  // namespace powderkeg

#include "common/model/evaluator.h"

#include <algorithm>
#include <bit>

#include "common/base/check.h"

namespace powderkeg {

namespace {

template <typename Number>
Action Best(std::span<const Number, kActionCount> policy, ActionSet legal) {
  CHECK(legal != 0);
  auto best = static_cast<std::size_t>(std::countr_zero(legal));
  for (std::size_t action = best + 1; action < kActionCount; ++action) {
    if (Has(legal, action) && policy[action] > policy[best]) best = action;
  }
  return static_cast<Action>(best);
}

}  // namespace

Action BestAction(std::span<const float, kActionCount> policy, ActionSet legal) {
  return Best(policy, legal);
}

Action BestAction(std::span<const std::uint8_t, kActionCount> policy, ActionSet legal) {
  return Best(policy, legal);
}

void UniformEvaluator::Evaluate(const GameSettings& /*settings*/,
                                std::span<const Position> /*positions*/,
                                std::span<Evaluation> evaluations) {
  Evaluation uniform{};
  uniform.policy.fill(1.0F / kActionCount);
  std::ranges::fill(evaluations, uniform);
}

}  // namespace powderkeg

#pragma once

// Samples as the arrays that one training step reads.

#include <array>
#include <span>
#include <vector>

#include "common/base/rng.h"
#include "common/model/outcome_value.h"
#include "common/pommerman/game_settings.h"
#include "learner/replay/lessons.h"

namespace powderkeg {

// Row-major arrays; the memory is kept between batches. A value.
struct TrainingBatch {
  std::size_t size = 0;
  std::vector<float> planes;    // [size, 23, 11, 11]
  std::vector<float> policies;  // [size, 6], each row a distribution or, without a target, all 0
  std::vector<float> values;    // [size], -1 to +1, the viewer's view
  // [size, 3, 6], of viewer + 1, + 2, + 3: 1 for what it did next (an action that its position does
  // not allow is a stop), 0 for all others, and of who is dead or was not in view.
  std::vector<float> others;
  std::vector<float> others_legal;  // [size, 3, 6], of the same: 1 what its position allows, else 0
};

// How targets are made; weights from 0 to 1.
struct TargetSettings {
  double argmax_weight = 0;        // of onehot(argmax pi) in the policy's target
  OutcomeValues outcome_values{};  // z
  double search_value_weight = 0;  // of the search's root value in the value's target, beside z;
                                   // demonstrations have none
};

// pi' = (1 - weight) pi + weight onehot(argmax pi), where pi is the visits' distribution; the
// smallest of equal actions counts as the largest. All 0 if the visits are: such a sample has no
// policy to learn and adds 0 to that part of the loss.
[[nodiscard]] std::array<float, kActionCount> PolicyTarget(
    const std::array<std::uint16_t, kActionCount>& visits, double argmax_weight);

// Fills `batch` with the samples, each turned by its own random symmetry of the square (boards
// smaller than 11x11 stay as they are).
void BuildBatch(const GameSettings& settings, const TargetSettings& targets,
                std::span<const Sample* const> samples, Rng& rng, TrainingBatch& batch);

}  // namespace powderkeg

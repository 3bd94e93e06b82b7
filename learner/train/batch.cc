#include "learner/train/batch.h"

#include <algorithm>
#include <numeric>

#include "common/model/planes.h"
#include "common/pommerman/observation.h"
#include "common/pommerman/symmetry.h"

namespace powderkeg {
namespace {

void EncodeState(const GameSettings& settings, const State& state, AgentId viewer,
                 std::span<float, kPlanesSize> planes) {
  const Cell cell = state.agents[static_cast<std::size_t>(viewer)].cell;
  EncodePlanes(settings, {&state, viewer, VisibleCells(settings, cell)}, planes);
}

}  // namespace

std::array<float, kActionCount> PolicyTarget(const std::array<std::uint16_t, kActionCount>& visits,
                                             double argmax_weight) {
  const double total = std::accumulate(visits.begin(), visits.end(), 0.0);
  std::array<float, kActionCount> target{};
  if (total == 0) return target;
  std::ranges::transform(visits, target.begin(), [&](std::uint16_t count) {
    return static_cast<float>((1 - argmax_weight) * count / total);
  });
  const auto best = std::ranges::max_element(visits) - visits.begin();
  target[static_cast<std::size_t>(best)] += static_cast<float>(argmax_weight);
  return target;
}

void BuildBatch(const GameSettings& settings, const TargetSettings& targets,
                std::span<const Sample* const> samples, Rng& rng, TrainingBatch& batch) {
  batch.size = samples.size();
  batch.planes.resize(samples.size() * kPlanesSize);
  batch.policies.resize(samples.size() * kActionCount);
  batch.values.resize(samples.size());
  const bool turns = settings.board_size == kBoardSize;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& sample = *samples[i];
    const Symmetry symmetry = turns ? static_cast<Symmetry>(rng.Below(kSymmetryCount)) : 0;
    const std::span planes(batch.planes.data() + i * kPlanesSize, kPlanesSize);
    EncodeState(settings, symmetry == 0 ? sample.state : Transform(symmetry, sample.state),
                sample.viewer, planes.first<kPlanesSize>());
    const auto target = PolicyTarget(sample.visits, targets.argmax_weight);
    float* const policy = batch.policies.data() + i * kActionCount;
    for (std::size_t action = 0; action < target.size(); ++action) {
      policy[static_cast<std::size_t>(Transform(symmetry, static_cast<Action>(action)))] =
          target[action];
    }
    const auto search_weight =
        sample.searched ? static_cast<float>(targets.search_value_weight) : 0.0F;
    const float outcome =
        ValueOf(targets.outcome_values, sample.outcome, sample.end_step, settings.max_steps);
    batch.values[i] = (1 - search_weight) * outcome + search_weight * sample.search_value;
  }
}

}  // namespace powderkeg

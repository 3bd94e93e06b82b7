#include "learner/train/batch.h"

#include <algorithm>
#include <numeric>

#include "common/model/planes.h"
#include "common/pommerman/observation.h"
#include "common/pommerman/symmetry.h"

namespace powderkeg {
namespace {

constexpr std::size_t kOthersSize = (kAgentCount - 1) * kActionCount;

// What the three others did in a position that was in view, and what they might have done.
void AddOthers(const GameSettings& settings, const Sample& sample, Symmetry symmetry, float* did,
               float* legal) {
  const State& state = sample.state;
  std::fill_n(did, kOthersSize, 0.0F);
  std::fill_n(legal, kOthersSize, 0.0F);
  const BitBoard visible = VisibleCells(settings, state.agents[sample.viewer].cell);
  for (AgentId i = 0; i < kAgentCount - 1; ++i, did += kActionCount, legal += kActionCount) {
    const AgentId agent = (sample.viewer + 1 + i) % kAgentCount;
    const AgentState& other = state.agents[static_cast<std::size_t>(agent)];
    if (!other.alive || !visible.Has(other.cell)) continue;
    const ActionSet allowed = LegalActions(state, agent);
    const auto turned = [&](int action) {
      return static_cast<std::size_t>(Transform(symmetry, static_cast<Action>(action)));
    };
    for (int action = 0; action < kActionCount; ++action) {
      legal[turned(action)] = static_cast<float>(allowed >> action & 1);
    }
    const auto action = static_cast<int>(sample.others[static_cast<std::size_t>(i)]);
    did[turned(Has(allowed, action) ? action : 0)] = 1;
  }
}

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
  batch.others.resize(samples.size() * kOthersSize);
  batch.others_legal.resize(samples.size() * kOthersSize);
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
    AddOthers(settings, sample, symmetry, batch.others.data() + i * kOthersSize,
              batch.others_legal.data() + i * kOthersSize);
    const auto search_weight =
        sample.searched ? static_cast<float>(targets.search_value_weight) : 0.0F;
    const float outcome =
        ValueOf(targets.outcome_values, sample.outcome, sample.end_step, settings.max_steps);
    batch.values[i] = (1 - search_weight) * outcome + search_weight * sample.search_value;
  }
}

}  // namespace powderkeg

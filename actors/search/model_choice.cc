#include "actors/search/model_choice.h"

#include <algorithm>

#include "actors/search/order_inference.h"

namespace powderkeg {
namespace {

constexpr int kFullScore = 1 << 16;
constexpr int kMemorySpan = 32;        // decisions that the score remembers
constexpr int kInitialLead = 1 << 13;  // of the model assumed at first

}  // namespace

void ModelChoice::Start(Memory memory, Rng rng) {
  memory_ = memory;
  rng_ = rng;
  candidates_ = {Candidate{PolicyKind::kSimpleUnbiased, {}, kInitialLead},
                 Candidate{PolicyKind::kOfficialSimple, {}, 0},
                 Candidate{PolicyKind::kIdle, {}, 0}};
}

void ModelChoice::Observe(const PolicyView& view, const PolicyTraits& traits, const State& after) {
  const auto id = static_cast<std::size_t>(view.self);
  Action seen = Action::kStop;
  if (!SeenAction(view.state, after, view.self, seen)) seen = Action::kStop;
  for (Candidate& candidate : candidates_) {
    PolicyMemory memory = candidate.memory;
    const bool foretold = Decide(candidate.policy, view, traits, memory, rng_) == seen;
    candidate.score += ((foretold ? kFullScore : 0) - candidate.score) / kMemorySpan;
    if (memory_ == Memory::kReset) continue;
    ObserveMove(candidate.policy, view.state.agents[id].cell, after.agents[id].cell,
                candidate.memory);
  }
}

const ModelChoice::Candidate& ModelChoice::best() const {
  return *std::ranges::max_element(candidates_, {}, &Candidate::score);
}

}  // namespace powderkeg

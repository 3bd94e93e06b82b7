#include "actors/search/model_choice.h"

#include <algorithm>

#include "actors/search/order_inference.h"

namespace powderkeg {
namespace {

constexpr int kFullScore = 1 << 16;
constexpr int kMemorySpan = 32;        // decisions that the score remembers
constexpr int kInitialLead = 1 << 13;  // of the model assumed at first

}  // namespace

void TakeIn(ModelMemory kind, PolicyKind policy, const PolicyView& view, const State& after,
            const PolicyTraits& traits, PolicyMemory& memory, Rng& rng) {
  const auto id = static_cast<std::size_t>(view.self);
  switch (kind) {
    case ModelMemory::kReset: break;
    case ModelMemory::kSynchronized:
      ObserveMove(policy, view.state.agents[id].cell, after.agents[id].cell, memory);
      break;
    case ModelMemory::kInferred: ObserveStep(policy, view, after, traits, memory, rng); break;
  }
}

void Reappear(ModelMemory kind, PolicyKind policy, Cell cell, PolicyMemory& memory) {
  if (kind != ModelMemory::kReset) ObserveMove(policy, cell, cell, memory);
}

void ModelChoice::Start(ModelMemory memory, Rng rng) {
  memory_ = memory;
  rng_ = rng;
  candidates_ = {Candidate{PolicyKind::kSimpleUnbiased, {}, kInitialLead},
                 Candidate{PolicyKind::kOfficialSimple, {}, 0},
                 Candidate{PolicyKind::kIdle, {}, 0}};
}

void ModelChoice::Observe(const PolicyView& view, const PolicyTraits& traits, const State& after) {
  Action seen = Action::kStop;
  if (!SeenAction(view.state, after, view.self, seen)) seen = Action::kStop;
  for (Candidate& candidate : candidates_) {
    PolicyMemory memory = candidate.memory;
    const bool foretold = Decide(candidate.policy, view, traits, memory, rng_) == seen;
    candidate.score += ((foretold ? kFullScore : 0) - candidate.score) / kMemorySpan;
    TakeIn(memory_, candidate.policy, view, after, traits, candidate.memory, rng_);
  }
}

void ModelChoice::Reappear(Cell cell) {
  for (Candidate& candidate : candidates_) {
    powderkeg::Reappear(memory_, candidate.policy, cell, candidate.memory);
  }
}

const ModelChoice::Candidate& ModelChoice::best() const {
  return *std::ranges::max_element(candidates_, {}, &Candidate::score);
}

}  // namespace powderkeg

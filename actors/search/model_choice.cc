#include "actors/search/model_choice.h"

#include <algorithm>

#include "actors/search/order_inference.h"
#include "actors/search/portable_math.h"

namespace powderkeg {
namespace {

constexpr double kFading = 1 - 1.0 / 32;  // of evidence, with every decision seen
constexpr double kInitialLead = 2;        // in evidence, of the model assumed at first
constexpr double kAnyAction = 0.1;        // probability that a model does not act as it should
constexpr int kDraws = 8;                 // of a decision that is drawn

// Of an agent that acts with probability `foretold` as seen, unless it does anything.
void Judge(double foretold, double& evidence) {
  evidence = kFading * evidence + Log((1 - kAnyAction) * foretold + kAnyAction / kActionCount);
}

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

void ModelChoice::Start(ModelMemory memory, bool with_prediction, Rng rng) {
  memory_ = memory;
  rng_ = rng;
  candidates_ = {Candidate{PolicyKind::kSimpleUnbiased, {}, kInitialLead},
                 Candidate{PolicyKind::kOfficialSimple, {}, 0},
                 Candidate{PolicyKind::kIdle, {}, 0}};
  with_prediction_ = with_prediction;
  prediction_evidence_ = 0;
}

void ModelChoice::Observe(const PolicyView& view, const PolicyTraits& traits, const State& after,
                          ForetoldActions foretold) {
  Action seen = Action::kStop;
  if (!SeenAction(view.state, after, view.self, seen)) seen = Action::kStop;
  const int foretold_sum = SumOf(foretold, LegalActions(view.state, view.self));
  const bool judges = !with_prediction_ || foretold_sum > 0;
  for (Candidate& candidate : candidates_) {
    if (judges) Judge(ProbabilityOf(seen, candidate, view, traits), candidate.evidence);
    TakeIn(memory_, candidate.policy, view, after, traits, candidate.memory, rng_);
  }
  if (foretold_sum > 0) {
    const double share = foretold[static_cast<std::size_t>(seen)];
    Judge(std::min(1.0, share / foretold_sum), prediction_evidence_);
  }
}

// That the policy alone does what was seen.
double ModelChoice::ProbabilityOf(Action seen, const Candidate& candidate, const PolicyView& view,
                                  const PolicyTraits& traits) {
  int right = 0;
  int draws = 0;
  for (bool drawn = true; drawn && draws < kDraws; ++draws) {
    const Rng before = rng_;
    PolicyMemory memory = candidate.memory;
    right += Decide(candidate.policy, view, traits, memory, rng_) == seen ? 1 : 0;
    drawn = !(rng_ == before);
  }
  return static_cast<double>(right) / draws;
}

void ModelChoice::Reappear(Cell cell) {
  for (Candidate& candidate : candidates_) {
    powderkeg::Reappear(memory_, candidate.policy, cell, candidate.memory);
  }
}

const ModelChoice::Candidate& ModelChoice::best() const {
  return *std::ranges::max_element(candidates_, {}, &Candidate::evidence);
}

bool ModelChoice::prefers_prediction() const {
  return with_prediction_ && prediction_evidence_ > best().evidence;
}

}  // namespace powderkeg

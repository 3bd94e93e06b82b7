#pragma once

// Finds out from what an agent does by which model it is best foretold.

#include <array>

#include "actors/search/foretelling.h"
#include "common/base/rng.h"
#include "common/config/search_settings.h"
#include "common/policies/policy.h"
#include "common/pommerman/state.h"

namespace powderkeg {

// What a model remembers of view.self after one real step, by the kind of memory: nothing, the
// positions where the agent was seen, or what the policy would remember after an action that
// explains what was seen.
void TakeIn(ModelMemory kind, PolicyKind policy, const PolicyView& view, const State& after,
            const PolicyTraits& traits, PolicyMemory& memory, Rng& rng);

// What it remembers of an agent that comes into view on `cell`: that place beside what it knew
// before, which foretells it better than an empty memory.
void Reappear(ModelMemory kind, PolicyKind policy, Cell cell, PolicyMemory& memory);

// Bayes' rule over rule-based policies and, where asked for, what the network foretells: each model
// is as likely as it made what was seen. All of them may do anything with a small probability; a
// policy that draws is asked several times. Evidence fades, so that a change of mind is noticed.
// A value; one thread; the same on every machine.
class ModelChoice {
 public:
  struct Candidate {
    PolicyKind policy = PolicyKind::kIdle;
    PolicyMemory memory;
    double evidence = 0;  // logarithm of its probability, up to a constant that all share
  };

  // Begins a game. The first candidate, SimpleUnbiased, is assumed until another one did better.
  void Start(ModelMemory memory, bool with_prediction, Rng rng);

  // Takes in that view.self, having seen `view`, did what leads to `after`, and what had been
  // foretold of it. Where nothing was, all models remember the step, but with prediction none is
  // judged by it.
  void Observe(const PolicyView& view, const PolicyTraits& traits, const State& after,
               ForetoldActions foretold);

  // The agent comes into view on `cell`; the evidence stays.
  void Reappear(Cell cell);

  // The likeliest policy.
  [[nodiscard]] const Candidate& best() const;
  // Whether the prediction is likelier than every policy.
  [[nodiscard]] bool prefers_prediction() const;

 private:
  [[nodiscard]] double ProbabilityOf(Action seen, const Candidate& candidate,
                                     const PolicyView& view, const PolicyTraits& traits);

  ModelMemory memory_ = ModelMemory::kSynchronized;
  Rng rng_;
  std::array<Candidate, 3> candidates_;
  bool with_prediction_ = false;
  double prediction_evidence_ = 0;
};

}  // namespace powderkeg

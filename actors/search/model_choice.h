#pragma once

// Finds out which rule-based policy an agent plays from what it does.

#include <array>

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

// Lets every candidate foretell every observed decision and keeps the score. A value; one thread.
class ModelChoice {
 public:
  struct Candidate {
    PolicyKind policy = PolicyKind::kIdle;
    PolicyMemory memory;
    // Share of decisions foretold, recent ones weighing more, in units of 2^-16.
    int score = 0;
  };

  // Begins a game. The first candidate, SimpleUnbiased, is assumed until another one did better.
  void Start(ModelMemory memory, Rng rng);

  // Takes in that view.self, having seen `view`, did what leads to `after`.
  void Observe(const PolicyView& view, const PolicyTraits& traits, const State& after);

  // The agent comes into view on `cell`; the score stays.
  void Reappear(Cell cell);

  [[nodiscard]] const Candidate& best() const;

 private:
  ModelMemory memory_ = ModelMemory::kSynchronized;
  Rng rng_;
  std::array<Candidate, 3> candidates_;
};

}  // namespace powderkeg

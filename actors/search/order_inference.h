#pragma once

// Finds out the hidden orders of a SimpleUnbiased agent from what it does.

#include <array>
#include <cstdint>
#include <vector>

#include "actors/search/escape.h"
#include "common/base/rng.h"
#include "common/policies/policy.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"

namespace powderkeg {

// What `agent` did in a step, where the positions around it tell: a move, or a bomb. False if it
// stayed without a bomb (it may have stopped or bounced) or out of sight.
[[nodiscard]] bool SeenAction(const State& before, const State& after, AgentId agent,
                              Action& action);

// Infers the orders from the decisions that depend on them, by Bayes' theorem with costs in bits:
// the negative logarithms to base 2 of probabilities.
//
// The six orders of the three others are compared one by one; they decide about approaching. The
// orders of rows and columns, which decide about escaping, are far too many: there 24 guesses stand
// for all that explain what was seen. A new escape decides which of them survive (resampling, as in
// the particle filter of Gordon, Salmond and Smith 1993); then each walks at random among what
// explains all escapes equally well (Metropolis et al. 1953), so that they go on to differ in
// whatever is still unknown (Gilks and Berzuini 2001).
//
// Integers only; no allocation once kMostEvidence escapes were seen. A value; one thread.
class OrderInference {
 public:
  // Begins a game with the guess `traits`.
  void Start(const PolicyTraits& traits, Rng rng);

  // Takes in that `view.self`, remembering `memory`, did `seen` in `view`.
  void Observe(const PolicyView& view, const PolicyMemory& memory, Action seen);

  // Chooses which guess traits() are, for an agent in the position of `view`: all explain the past,
  // but the majority foretells the next move more often than any one does. It is the guess that
  // goes with the majority in the next moves of the agent's escape or, where it is in no danger,
  // of an escape from a bomb that it would lay now; the first move counts most. view.self must be
  // alive.
  void Settle(const PolicyView& view);

  [[nodiscard]] const PolicyTraits& traits() const { return traits_; }

 private:
  // Orders of rows and columns, and what all evidence says against them.
  struct Guess {
    PolicyTraits traits;
    int cost = 0;
  };
  struct Evidence {
    Escape escape;
    Direction seen = Direction::kNone;

    [[nodiscard]] int CostOf(const PolicyTraits& traits) const;
  };
  static constexpr std::size_t kAgentOrders = 6;
  static constexpr std::size_t kGuesses = 24;
  static constexpr std::size_t kMostEvidence = 64;  // the oldest goes first

  void LearnAgentOrder(const PolicyView& view, const PolicyMemory& memory, Action seen);
  void LearnCells(const Evidence& evidence);
  void Keep(const Evidence& evidence);
  void Resample(const Evidence& evidence);
  void Walk(Guess& guess);
  // What all evidence says against `traits`, or a part of it that is more than `enough`.
  [[nodiscard]] int CostOf(const PolicyTraits& traits, int enough) const;
  // The move that most guesses make; adds `weight` for those that make it.
  [[nodiscard]] Direction Vote(const Escape& escape, int weight,
                               std::array<int, kGuesses>& agreement) const;

  PolicyTraits traits_;
  Rng rng_;
  std::array<int, kAgentOrders> agent_order_costs_{};
  std::array<Guess, kGuesses> guesses_;
  std::size_t settled_ = 0;  // the guess that traits_ are
  std::vector<Evidence> evidence_;
  std::size_t oldest_ = 0;  // of a full evidence_
};

}  // namespace powderkeg

#pragma once

// Finds out the hidden orders of a SimpleUnbiased agent from what it does.

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/rng.h"
#include "common/policies/policy.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"

namespace powderkeg {

// What `agent` did in a step, where the positions around it tell: a move, or a bomb. False if it
// stayed without a bomb (it may have stopped or bounced) or out of sight.
[[nodiscard]] bool SeenAction(const State& before, const State& after, AgentId agent,
                              Action& action);

// Keeps one guess. The six orders of the three others are compared one by one. Row and column
// orders are far too many: a random walk changes the guess wherever that does not contradict more
// of the decisions seen so far (of those that depend on the orders at all). Integers only. A value;
// one thread.
class OrderInference {
 public:
  // Begins a game with the guess `traits`.
  void Start(const PolicyTraits& traits, Rng rng);

  // Takes in that `view.self`, remembering `memory`, did `seen` in `view`.
  void Observe(const PolicyView& view, const PolicyMemory& memory, Action seen);

  [[nodiscard]] const PolicyTraits& traits() const { return traits_; }

 private:
  // A decision that depends on the orders of rows and columns.
  struct Evidence {
    State state;
    BitBoard visible;
    PolicyMemory memory;
    Action seen;
  };
  static constexpr std::size_t kAgentOrders = 6;

  // Whether the decision depends on the order of agents; if so, counts against contradicted ones.
  bool JudgeAgentOrders(const PolicyView& view, const PolicyMemory& memory, Action seen);
  [[nodiscard]] bool DependsOnCells(const PolicyView& view, const PolicyMemory& memory);
  // What all evidence says against `traits`, or a part of it that is more than `enough`.
  [[nodiscard]] int CostOf(const PolicyTraits& traits, const GameSettings& game, AgentId agent,
                           int enough) const;
  void Improve(const GameSettings& game, AgentId agent);

  PolicyTraits traits_;
  Rng rng_;
  std::array<int, kAgentOrders> agent_order_costs_{};
  std::vector<Evidence> evidence_;
};

}  // namespace powderkeg

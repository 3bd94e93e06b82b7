#pragma once

// What the searching agent assumes of the others, carried through a real game.

#include <array>
#include <cstdint>

#include "actors/search/order_inference.h"
#include "actors/search/search_settings.h"
#include "common/base/rng.h"
#include "common/policies/policy.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"

namespace powderkeg {

// The model of one agent. Traits hold for a search; the memory is what the search's root starts
// from.
struct ModelledAgent {
  OpponentModel model = OpponentModel::kIdle;
  PolicyTraits traits;
  PolicyMemory memory;

  friend bool operator==(const ModelledAgent&, const ModelledAgent&) = default;
};

// Whether the model is a rule-based policy, and which. Requires a model other than kRawNetwork.
[[nodiscard]] PolicyKind PolicyOf(OpponentModel model);

// A value, one per searching agent and game: StartGame, then ObserveStep once per real step. Reads
// only what the agent's belief holds.
class OpponentModels {
 public:
  OpponentModels() = default;

  // Forgets everything. Unknown traits are drawn from `rng`.
  void StartGame(const SearchSettings& settings, const GameSettings& game, AgentId self, Rng rng);

  // Takes in one real step from the believed positions before and after it.
  void ObserveStep(const State& before, const State& after);

  [[nodiscard]] AgentId self() const { return self_; }
  // Requires agent != self().
  [[nodiscard]] const ModelledAgent& Of(AgentId agent) const {
    return agents_[static_cast<std::size_t>(agent)];
  }

 private:
  void InferOrders(const State& before, const State& after, AgentId agent);

  ModelMemory memory_ = ModelMemory::kSynchronized;
  GameSettings game_;
  AgentId self_ = 0;
  std::array<ModelledAgent, kAgentCount> agents_;
  std::array<OrderInference, kAgentCount> orders_;  // used where the memory setting is kInferred
};

}  // namespace powderkeg

#pragma once

// What the searching agent assumes of the others, carried through a real game.

#include <array>
#include <cstdint>

#include "actors/search/foretelling.h"
#include "actors/search/model_choice.h"
#include "actors/search/order_inference.h"
#include "common/base/rng.h"
#include "common/config/search_settings.h"
#include "common/policies/policy.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"

namespace powderkeg {

// How one agent is assumed to act. Policy and traits hold for a search; the memory is what its root
// starts from.
struct ModelledAgent {
  enum class Kind : std::uint8_t { kPolicy, kPredicted, kNetwork };
  Kind kind = Kind::kPolicy;
  PolicyKind policy = PolicyKind::kIdle;  // of a kPolicy
  PolicyTraits traits;
  PolicyMemory memory;
  bool foretold = false;  // kPredicted, or may become so: the answer to a position tells of it

  friend bool operator==(const ModelledAgent&, const ModelledAgent&) = default;
};

// The model in the words of the settings.
[[nodiscard]] OpponentModel ModelOf(const ModelledAgent& agent);

// A position as an agent believes it, and the cells that it had in view.
struct SeenState {
  const State& state;
  BitBoard visible = BitBoard::All();
};

// A value, one per searching agent and game: StartGame, then ObserveStep once per real step. Reads
// only what the agent's belief holds, and learns of another agent only what was seen of it: where
// one is believed out of sight says nothing of what it does.
class OpponentModels {
 public:
  OpponentModels() = default;

  // Forgets everything. Unknown traits are drawn from `rng`.
  void StartGame(const SearchSettings& settings, const GameSettings& game, AgentId self, Rng rng);

  // Takes in one real step. An agent that was not in view both before and after it may have done
  // anything: its model stays as it is, but that one coming into view remembers where it is.
  // `foretold` is what self's network had said of the others before the step.
  void ObserveStep(const SeenState& before, const SeenState& after,
                   const Foretelling& foretold = {});

  // For who knows what an agent hides: its model gets these traits instead of guessed ones. Once
  // per game, after StartGame; with ModelMemory::kInferred they are guessed again.
  void KnowTraits(AgentId agent, const PolicyTraits& traits);

  [[nodiscard]] AgentId self() const { return self_; }
  // Requires agent != self().
  [[nodiscard]] const ModelledAgent& Of(AgentId agent) const {
    return others_[static_cast<std::size_t>(agent)].model;
  }

 private:
  struct Other {
    ModelledAgent model;
    bool chooses = false;   // the model is chosen by `choice`
    ModelChoice choice;     // where it is
    OrderInference orders;  // where the memory setting is kInferred
    Rng rng = Rng(0);       // of guesses about its memory
  };
  [[nodiscard]] PolicyView ViewOf(const State& state, AgentId agent) const;
  void ObserveAgent(AgentId agent, const State& before, const State& after,
                    const Foretelling& foretold, Other& other) const;
  void InferOrders(AgentId agent, const State& before, const State& after, Other& other) const;
  void Reappear(Cell cell, Other& other) const;

  ModelMemory memory_ = ModelMemory::kSynchronized;
  GameSettings game_;
  AgentId self_ = 0;
  std::array<Other, kAgentCount> others_;
};

}  // namespace powderkeg

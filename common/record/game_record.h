#pragma once

// A finished game as the actors send it and the learner stores it: how it started, what everybody
// did, and what the search found. Planes and positions are not stored; they follow by stepping.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/policies/policy.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/generate.h"
#include "common/pommerman/step.h"

namespace powderkeg {

// Who plays a seat: a search whose decisions are recorded, or a rule-based policy.
struct Seat {
  bool searches = false;
  PolicyKind policy = PolicyKind::kIdle;  // where it does not search

  friend bool operator==(const Seat&, const Seat&) = default;
};

// Everything that determines a game up to the actions of its searching seats.
struct GameSetup {
  GameSettings settings;
  StartSettings start;
  std::array<Seat, kAgentCount> seats;
  std::uint64_t seed = 0;

  friend bool operator==(const GameSetup&, const GameSetup&) = default;
};

// The generators of a game, split from its seed.
[[nodiscard]] Rng BoardRng(const GameSetup& setup);                 // GenerateStart
[[nodiscard]] Rng SeatRng(const GameSetup& setup, AgentId seat);    // traits first, then decisions
[[nodiscard]] Rng SearchRng(const GameSetup& setup, AgentId seat);  // search; not verifiable

// One searched move of one agent. Moves made without a search (one legal action) have none.
struct Decision {
  std::uint16_t step = 0;  // steps played before it
  std::uint8_t agent = 0;
  // The policy to learn as counts of at most 65,535 (visits, as a rule). All 0: there is none, as
  // the search was too short to learn from; the decision is a sample of the value alone.
  std::array<std::uint16_t, kActionCount> visits{};
  float value = 0;                    // of the root, the agent's view, -1 to +1
  std::uint32_t weights_version = 0;  // that answered; 0 for the uniform evaluator

  friend bool operator==(const Decision&, const Decision&) = default;
};

struct GameRecord {
  // The ticket the game was played for: its number in start order, and its identity.
  std::uint64_t ticket = 0;
  GameSetup setup;
  std::uint32_t weights_version = 0;  // at the start of the game
  std::string evaluator;              // Evaluator::name()
  std::vector<JointAction> actions;   // one per step; kStop for the dead
  std::vector<Decision> decisions;    // ascending by (step, agent)
  // After the last recorded step. A game may be recorded only to the death of its last searching
  // seat; then outcome.done may be false and every searching seat lost.
  Outcome outcome;

  friend bool operator==(const GameRecord&, const GameRecord&) = default;
};

// +1 win, 0 tie, -1 loss of `agent` in the recorded game (the value target). Where the game was not
// played to its end, searching seats lost and the others' outcome is unknown: 0.
[[nodiscard]] int OutcomeFor(const GameRecord& record, AgentId agent);

// Regenerates the start, re-runs the rule-based seats, steps the recorded actions and checks every
// claim of the record (decisions belong to living searching seats in order, their actions exist,
// the outcome is the true one, nothing follows the end). Returns the reason for refusal, or
// nullopt. Never throws, safe on records from peers. `visitor`, if given, is called for each
// decision with the position it was made in (before a collapse) and the action that was played,
// until a reason is found.
using PositionVisitor = void (*)(void* context, const State& state, const Decision& decision,
                                 Action action);
[[nodiscard]] std::optional<std::string> Verify(const GameRecord& record,
                                                PositionVisitor visitor = nullptr,
                                                void* context = nullptr);

}  // namespace powderkeg

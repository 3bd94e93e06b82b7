#pragma once

// A finished game as the actors send it and the learner stores it: how it started, what everybody
// did, and what the search found. Planes and positions are not stored; they follow by stepping.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/config/players.h"
#include "common/policies/policy.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/generate.h"
#include "common/pommerman/step.h"

namespace powderkeg {

using Teaches = PlayerSpec::Teaches;

// Who plays a seat, and what the game is played for there.
struct Seat {
  bool searches = false;                  // an agent moves it; it cannot be re-run
  PolicyKind policy = PolicyKind::kIdle;  // that moves it where it does not search
  Teaches teaches = Teaches::kNothing;    // kSearch only where it searches
  bool measured = false;                  // its result counts: it teaches, or sits an exam
  std::uint8_t player = 0;                // index among the players of the run or match

  friend bool operator==(const Seat&, const Seat&) = default;
};

// Everything that determines a game up to the actions of its searching seats.
struct GameSetup {
  GameSettings settings;
  StartSettings start;
  std::array<Seat, kAgentCount> seats;
  std::uint64_t seed = 0;
  std::uint8_t lineup = 0;  // index among the line-ups of the run
  bool to_the_end = true;   // otherwise only until no measured seat can win any more

  friend bool operator==(const GameSetup&, const GameSetup&) = default;
};

// The generators of a game, split from its seed.
[[nodiscard]] Rng BoardRng(const GameSetup& setup);                 // GenerateStart
[[nodiscard]] Rng SeatRng(const GameSetup& setup, AgentId seat);    // traits first, then decisions
[[nodiscard]] Rng SearchRng(const GameSetup& setup, AgentId seat);  // search; not verifiable

// One searched move. Moves made without a search (one legal action) have none.
struct Decision {
  std::uint16_t step = 0;  // steps played before it
  // The policy to learn as counts of at most 65,535 (visits, as a rule). All 0: there is none, as
  // the search was too short to learn from; the decision is a sample of the value alone.
  std::array<std::uint16_t, kActionCount> visits{};
  float value = 0;                    // of the root, the agent's view, -1 to +1
  std::uint32_t weights_version = 0;  // that answered; 0 for the uniform evaluator

  friend bool operator==(const Decision&, const Decision&) = default;
};

// One seat's own story of a game, beside its actions.
struct Track {
  std::uint32_t weights_version = 0;  // at the start of the game; 0: no network
  std::vector<Decision> decisions;    // ascending by step; only of a seat that teaches its search

  friend bool operator==(const Track&, const Track&) = default;
};

struct GameRecord {
  // The ticket the game was played for: its number in start order, and its identity.
  std::uint64_t ticket = 0;
  GameSetup setup;
  std::string evaluator;                  // Evaluator::name() of the first searching seat
  std::vector<JointAction> actions;       // one per step; kStop for the dead
  std::array<Track, kAgentCount> tracks;  // by agent
  // After the last recorded step. If it is not done, no measured seat could win any more: all lost.
  Outcome outcome;

  friend bool operator==(const GameRecord&, const GameRecord&) = default;
};

// Of all tracks.
[[nodiscard]] std::size_t DecisionCount(const GameRecord& record);

// Whether a game of this setup ends in `state` although the environment goes on: seats are
// measured, and none of their sides lives.
[[nodiscard]] bool EndsEarly(const GameSetup& setup, const State& state);

// +1 win, 0 tie, -1 loss of `agent` in the recorded game, officially. Where the game was not played
// to its end, measured seats lost and the others' outcome is unknown: 0.
[[nodiscard]] int OutcomeFor(const GameRecord& record, AgentId agent);

// Looks on while a record is played again: called once per step, with the position that was decided
// on (before a collapse; in radio games with the words that led to it, which follow from the
// record) and what everybody did there.
using StepObserver = std::function<void(const State& state, const JointAction& actions)>;

// Regenerates the start, re-runs the rule-based seats, steps the recorded actions and checks every
// claim of the record (decisions belong to living seats that teach their search, in order; their
// actions exist; the outcome is the true one; nothing follows the end). Returns the reason for
// refusal, or nullopt. Never throws, safe on records from peers. `observer` is called until a
// reason is found.
[[nodiscard]] std::optional<std::string> Verify(const GameRecord& record,
                                                const StepObserver& observer = nullptr);

}  // namespace powderkeg

#pragma once

// The official rules: one step of the game, its outcome, the collapsing board.

#include <array>
#include <cstdint>

#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"

namespace powderkeg {

enum class Result : std::uint8_t { kIncomplete, kWin, kTie };

// What the environment tells after a step.
struct Outcome {
  bool done = false;
  Result result = Result::kIncomplete;
  // Bit i: agent i won (in team modes both of the team, a dead one too). 0 unless result is kWin.
  std::uint8_t winners = 0;
  std::array<std::int8_t, kAgentCount> rewards{};  // -1, 0, +1

  [[nodiscard]] constexpr bool Won(AgentId agent) const {
    return Has(winners, static_cast<std::size_t>(agent));
  }

  friend bool operator==(const Outcome&, const Outcome&) = default;
};

// Plays one step, rules 3.1 to 3.12: a pure function of its arguments. Actions of dead agents are
// ignored. Never ends a game by itself; stepping a finished game is allowed.
void Step(const GameSettings& settings, const JointAction& actions, State& state);

// As above in radio mode, with the words that every agent sends along; those of agents that were
// dead before the step are ignored. Without words everybody is silent.
void Step(const GameSettings& settings, const JointAction& actions,
          const std::array<Message, kAgentCount>& messages, State& state);

// Done, result and rewards after a step (rules, section 4).
[[nodiscard]] Outcome OutcomeOf(const GameSettings& settings, const State& state);

// Turns a ring into rigid walls if one collapses after this many steps (rules, section 5); nothing
// otherwise. The official order is Step, OutcomeOf, observations, Collapse.
void Collapse(const GameSettings& settings, State& state);

// Step, OutcomeOf and Collapse in the official order.
inline Outcome Advance(const GameSettings& settings, const JointAction& actions, State& state) {
  Step(settings, actions, state);
  const Outcome outcome = OutcomeOf(settings, state);
  Collapse(settings, state);
  return outcome;
}

// A set of actions; bit i is Action i.
using ActionSet = std::uint8_t;

// The paper's action filter: stop always; bomb with ammo and no bomb under the agent; a direction
// if the next cell is a passage or visible item, a bomb and the agent can kick, or a flame that is
// gone in the next step. Cells of living agents are not legal targets. Requires a living agent.
[[nodiscard]] ActionSet LegalActions(const State& state, AgentId agent);

}  // namespace powderkeg

#pragma once

// A rule-based player of one game: the same code moves it when the game is played and when a record
// of it is verified.

#include "common/record/game_record.h"

namespace powderkeg {

// Everything follows from the setup: SeatRng first draws the hidden traits, then serves the
// decisions. A value; one game.
class RuleBasedSeat {
 public:
  RuleBasedSeat() = default;
  // The seat at the start of the game. Requires that it does not search.
  RuleBasedSeat(const GameSetup& setup, AgentId seat)
      : kind_(setup.seats[seat].policy),
        self_(seat),
        rng_(SeatRng(setup, seat)),
        traits_(PolicyTraits::Draw(rng_)) {}

  // The move on `state`; it looks only at what the settings let it see. Call it once per step, as
  // long as the agent lives. Where the board collapses it decides on the position before that.
  [[nodiscard]] Action Decide(const GameSettings& settings, const State& state);

  [[nodiscard]] const PolicyTraits& traits() const { return traits_; }
  [[nodiscard]] const PolicyMemory& memory() const { return memory_; }

 private:
  PolicyKind kind_ = PolicyKind::kIdle;
  AgentId self_ = 0;
  Rng rng_;
  PolicyTraits traits_;
  PolicyMemory memory_;
};

}  // namespace powderkeg

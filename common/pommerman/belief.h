#pragma once

// What one agent can know of the position, from its observations alone.

#include <array>
#include <cstdint>

#include "common/pommerman/game_settings.h"
#include "common/pommerman/observation.h"
#include "common/pommerman/radio_code.h"
#include "common/pommerman/state.h"

namespace powderkeg {

struct Sight;  // what one observation shows, as sets and lists (belief.cc)

// Turns the stream of one agent's observations into the State its search steps from: hidden items
// are unknown (none), bombs have the owner that can have laid them, opponents' statistics are
// inferred. A value; give it every observation of a game in order, the first one included.
//
// Each observation is first predicted: the moves that were seen are played on the believed
// position. What is seen then overrides what was predicted. (After a gap in the steps nothing is
// predicted.) With the whole board in view only this cannot be known, and is put right as soon as
// it shows: an item that another agent picks up in the very step in which it comes out of the
// flames.
//
// Fog: a cell never seen counts as passage for Step. A remembered bomb out of sight goes on
// ticking, rolling and exploding as Step would have it; an agent out of sight stays on the cell
// where it was seen last (on its start corner if never), is believed alive as long as the
// observation says so, and moves to the nearest free cell out of sight when it cannot be there
// any more. A bomb that comes into view is taken for that of the nearest other agent.
//
// Radio: a living mate out of sight is believed where it says it is (radio_code.h) or, where it
// cannot be there, on the nearest cell out of sight that is free and without an item: off by a few
// cells, but better than where it was seen last. Words are not part of the position.
class Belief {
 public:
  explicit Belief(const GameSettings& settings) : settings_(settings) {}

  void Observe(const Observation& observation);
  // What `viewer` sees of the true position, taken before Collapse: the same as
  // Observe(powderkeg::Observe(settings, truth, viewer)) in less than half the time.
  void Observe(const State& truth, AgentId viewer);

  // What an agent that plays `action` on this tells its mate (radio_code.h).
  [[nodiscard]] Message Report(Action action) const;

  // The position that the next action is played on, so after a collapse; `self` is alive in it as
  // long as it was observed alive. Requires one Observe.
  [[nodiscard]] const State& state() const { return state_; }
  [[nodiscard]] AgentId self() const { return self_; }
  // Cells in view in the last observation.
  [[nodiscard]] BitBoard visible() const { return visible_; }
  // Cells seen at least once in this game.
  [[nodiscard]] BitBoard ever_seen() const { return ever_seen_; }

 private:
  void See(const Sight& sight);
  void Listen(const Message& message);

  GameSettings settings_;
  State state_;
  MateTracker mate_;  // radio
  AgentId self_ = 0;
  BitBoard visible_;
  BitBoard ever_seen_;
};

}  // namespace powderkeg

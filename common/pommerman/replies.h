#pragma once

// What agents nearby may answer to a move, and the worst that they may do next.

#include <array>

#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"
#include "common/pommerman/step.h"

namespace powderkeg {

// The living enemies of `self`.
[[nodiscard]] AgentSet LivingEnemies(Mode mode, const State& state, AgentId self);

// What everybody else may do in a step.
struct Replies {
  static constexpr int kRepliers = 2;
  std::array<JointAction, 1 + kRepliers*(kActionCount - 1)> actions{};
  int count = 1;  // the first: all wait
};

// Every action of each of the two that are nearest to `self`, one at a time, of those of `repliers`
// that are within `near` steps (Manhattan); everybody else waits, `self` does, too.
[[nodiscard]] Replies RepliesTo(const State& state, AgentId self, AgentSet repliers, int near);

// Lays a fresh bomb under every living agent of `layers` within `near` steps of `self` that has one
// and stands on none; false where nobody could.
bool LayBombs(AgentId self, AgentSet layers, int near, State& state);

}  // namespace powderkeg

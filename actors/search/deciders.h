#pragma once

// Who decides inside the tree during one environment step: all that one- and two-player search
// differ in.

#include "common/config/search_settings.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"

namespace powderkeg {

// The enemy whose moves branch after those of `self` in this step, or `self` if nobody's do: in a
// one-player tree, and where no living enemy is in reach. Everybody else acts by model.
[[nodiscard]] AgentId DeciderAfter(const SearchSettings& settings, const GameSettings& game,
                                   const State& state, AgentId self);

}  // namespace powderkeg

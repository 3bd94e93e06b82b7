#pragma once

// Who goes where in one step: rules 3.2 to 3.8.

#include <array>

#include "common/pommerman/state.h"
#include "common/pommerman/types.h"

namespace powderkeg {

// Moves living agents and rolling bombs of a position whose flames have aged and whose new bombs
// are laid, with all bounces, kicks and undone kicks. Items stay where they are. Returns the cells
// of the living agents afterwards.
BitBoard MoveAgentsAndBombs(const JointAction& actions, State& state);

}  // namespace powderkeg

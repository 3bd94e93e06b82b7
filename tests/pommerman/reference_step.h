#pragma once

// The rules a second time, written down word by word from their specification, without a thought
// for speed: what Step is compared with.

#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"
#include "common/pommerman/types.h"

namespace powderkeg {

// As Step. Shares no code with it but the vocabulary of types.h and state.h.
void ReferenceStep(const GameSettings& settings, const JointAction& actions, State& state);

}  // namespace powderkeg

#pragma once

// Games in which something happens all the time, for property tests.

#include <functional>

#include "common/base/rng.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"
#include "common/pommerman/step.h"

namespace powderkeg {

// A start position with an open board, many bombs and kickers, so that random play meets kicks,
// rolling bombs and chains of explosions. A function of the seed.
[[nodiscard]] State CrowdedStart(const GameSettings& settings, std::uint64_t seed);

// A crowded start for even seeds, an official one for odd seeds.
[[nodiscard]] State RandomStart(const GameSettings& settings, std::uint64_t seed);

// Moves more often than bombs, so that games last.
[[nodiscard]] JointAction RandomActions(Rng& rng);

using StepVisitor = std::function<void(const GameSettings& settings, const State& before,
                                       const JointAction& actions, const State& after)>;

// Plays random games to their end, half from official and half from crowded starts, with every
// 11x11 official environment, and shows each step (after a collapse, if one follows). Stops at a
// fatal GoogleTest failure.
void ForEachRandomStep(int games_per_setting, const StepVisitor& visit);

}  // namespace powderkeg

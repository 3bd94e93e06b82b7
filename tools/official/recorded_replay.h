#pragma once

// The proof that Step plays by the official rules: recorded games, played again.

#include <string>
#include <vector>

#include "common/recorded/recorded_game.h"

namespace powderkeg {

// What the official environment shows an agent.
[[nodiscard]] RecordedObservation OfficialObservation(const GameSettings& settings,
                                                      const State& state, AgentId self);

// Plays the recorded actions from the recorded start. Returns one text for each difference in a
// state, a reward, the end, the result or an observation; none if all is equal. Goes on from the
// recorded state after a difference. Requires game.Known().
[[nodiscard]] std::vector<std::string> ReplayDifferences(const RecordedGame& game);

}  // namespace powderkeg

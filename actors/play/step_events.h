#pragma once

// Who did what to whom in a step: bombs, kicks, and deaths by whose flames.

#include <array>
#include <cstdint>

#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"

namespace powderkeg {

// Bit i of a set of agents is agent i.
using AgentSet = std::uint8_t;

struct StepEvents {
  AgentSet laid = 0;    // laid a bomb
  AgentSet kicked = 0;  // set a bomb rolling
  AgentSet burnt = 0;   // died in flames
  // Of an agent that died in flames: whose bombs they came from, its own included; a chain's flames
  // belong to the owners of the bombs that made them. Empty where the flames are older than the
  // watch.
  std::array<AgentSet, kAgentCount> killers{};

  friend bool operator==(const StepEvents&, const StepEvents&) = default;
};

// Watches a game step by step, as a position does not say whose flames burn in it. A value.
class StepWatcher {
 public:
  // What happened in the step from `before` to `after` (which a collapse has not changed yet).
  // Requires every step of the game, in order.
  [[nodiscard]] StepEvents Watch(const GameSettings& settings, const State& before,
                                 const JointAction& actions, const State& after);

 private:
  // flames_[agent][life]: cells that burn by that agent's bombs.
  std::array<std::array<BitBoard, 3>, kAgentCount> flames_;
};

}  // namespace powderkeg

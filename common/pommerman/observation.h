#pragma once

// What one agent is shown: the fields of the official observation.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"

namespace powderkeg {

// Per-cell arrays are indexed by Cell and hold official units. Fog is CellValue::kFog in `board`
// and 0 in the other arrays.
struct Observation {
  std::array<CellValue, kCellCount> board;
  std::array<std::uint8_t, kCellCount> bomb_blast_strength;  // 0: no bomb
  std::array<std::uint8_t, kCellCount> bomb_life;            // 0: no bomb
  std::array<Direction, kCellCount> bomb_moving_direction;
  std::array<std::uint8_t, kCellCount> flame_life;  // remaining life + 1, 1..3; 0: none
  std::array<bool, kAgentCount> alive;              // of every agent, in every mode
  AgentId self;
  std::uint8_t position;        // own cell
  std::uint8_t blast_strength;  // own
  bool can_kick;                // own
  std::uint8_t ammo;            // own
  std::uint16_t step;
  Message message;  // the team mate's, radio only

  friend bool operator==(const Observation&, const Observation&) = default;
};

// Observes `state` as agent `self`, dead or alive. Take it before Collapse.
[[nodiscard]] Observation Observe(const GameSettings& settings, const State& state, AgentId self);

// What the official observation says beside an Observation: the same in every step of a game.
struct OfficialFields {
  CellValue team_mate = CellValue::kAgentDummy;
  std::vector<CellValue> enemies;
  std::string environment;  // the official class, e.g. "pommerman.envs.v0:Pomme"
};
[[nodiscard]] OfficialFields OfficialFieldsOf(const GameSettings& settings, AgentId self);

// The cells that an agent on `position` sees.
[[nodiscard]] BitBoard VisibleCells(const GameSettings& settings, Cell position);

}  // namespace powderkeg

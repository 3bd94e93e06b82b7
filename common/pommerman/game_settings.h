#pragma once

// Which Pommerman is played: everything that an official environment id stands for, as one value.

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "common/pommerman/types.h"

namespace powderkeg {

// Values are the official game types.
enum class Mode : std::uint8_t { kFreeForAll = 1, kTeam = 2, kTeamRadio = 3, kOneVsOne = 4 };

// An immutable value. The default is PommeFFACompetition-v0.
struct GameSettings {
  Mode mode = Mode::kFreeForAll;
  int board_size = kBoardSize;  // 11, or 8 for one-against-one
  int max_steps = 800;          // a game not decided by then is a tie
  int blast_strength_cap = 10;  // cap at pick-up (spec: strength := min(strength + 1, cap))
  int view_radius = 0;          // cells seen in each direction; 0: the whole board
  // Steps after which ring k of the board turns into rigid walls; 0: never.
  std::array<int, 4> collapse_steps = {0, 0, 0, 0};

  friend bool operator==(const GameSettings&, const GameSettings&) = default;
};

// The settings of an official environment id such as "PommeTeamCompetition-v0"; nullopt if unknown.
[[nodiscard]] std::optional<GameSettings> GameSettingsFor(std::string_view environment_id);
// Every known id, separated by ", ": for error messages and --help.
[[nodiscard]] std::string KnownEnvironmentIds();

[[nodiscard]] constexpr bool IsTeamMode(Mode mode) {
  return mode == Mode::kTeam || mode == Mode::kTeamRadio;
}
// Agents play as 0, 1, ... up to this one; the others are dead from the start.
[[nodiscard]] constexpr int SeatCount(Mode mode) {
  return mode == Mode::kOneVsOne ? 2 : kAgentCount;
}
// The agent on the same side, or -1 without teams.
[[nodiscard]] constexpr AgentId TeamMateOf(Mode mode, AgentId agent) {
  return IsTeamMode(mode) ? (agent + 2) % kAgentCount : -1;
}
// Whether `other` is to be beaten by `agent`; nobody is one's own enemy.
[[nodiscard]] constexpr bool AreEnemies(Mode mode, AgentId agent, AgentId other) {
  return agent != other && !(IsTeamMode(mode) && (agent + other) % 2 == 0);
}

}  // namespace powderkeg

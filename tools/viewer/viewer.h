#pragma once

// Positions of stored games for a terminal.

#include <cstdint>
#include <string>

#include "tools/viewer/stored_game.h"

namespace powderkeg {

enum class Colours : std::uint8_t { kNone, kAnsi };

// The board after `step` steps beside what is known of the agents: the board in two characters a
// cell, with row and column numbers,
//
//   .. passage   ## rigid   ++ wood   *2 flame of life 2 (the longest of several)
//   o7 bomb with 7 steps to live, <7 >7 ^7 v7 while it rolls
//   +b +r +k     extra bomb, increase range, kick
//   A0 agent 0, 07 the same on a bomb of life 7
//
// and per agent who plays it, its place and statistics and the move it makes from here, with the
// shares of the search's visits and the value it expects (-1 to +1) where they are stored. Ends
// with a newline.
[[nodiscard]] std::string RenderStep(const StoredGame& stored, int step, Colours colours);

}  // namespace powderkeg

#pragma once

// Which cells an exploding bomb burns.

#include "common/pommerman/bit_board.h"

namespace powderkeg {

// The cells that a bomb on `cell` burns (rules 3.10): its own and up to strength - 1 in each
// direction; a ray ends before rigid and on wood, nothing else stops it. Requires strength >= 1.
[[nodiscard]] BitBoard BlastCells(Cell cell, int strength, BitBoard rigid, BitBoard wood);

}  // namespace powderkeg

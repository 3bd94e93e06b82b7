#pragma once

// The eight symmetries of the square.

#include <array>

#include "common/pommerman/state.h"

namespace powderkeg {

// 0..7: bit 2 mirrors columns first, bits 0 and 1 then count quarter turns clockwise.
using Symmetry = int;
inline constexpr int kSymmetryCount = 8;

[[nodiscard]] Cell Transform(Symmetry symmetry, Cell cell);
[[nodiscard]] Direction Transform(Symmetry symmetry, Direction direction);
// Stop and bomb stay; moves turn with the board.
[[nodiscard]] Action Transform(Symmetry symmetry, Action action);
// The whole position; agents keep their ids. Requires an 11x11 game.
[[nodiscard]] State Transform(Symmetry symmetry, const State& state);

}  // namespace powderkeg

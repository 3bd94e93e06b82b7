#pragma once

// The lines through a cell: how both rule-based agents judge what a bomb threatens.

#include <array>

#include "common/pommerman/bit_board.h"

namespace powderkeg {

namespace internal {

consteval std::array<std::array<BitBoard, kBoardSize>, kCellCount> MakeCrosses() {
  std::array<std::array<BitBoard, kBoardSize>, kCellCount> crosses;
  for (Cell cell = 0; cell < kCellCount; ++cell) {
    BitBoard up = BitBoard::Of(cell), down = up, left = up, right = up, cross = up;
    for (int reach = 0; reach < kBoardSize; ++reach) {
      crosses[cell][reach] = cross;
      up = up.Up(), down = down.Down(), left = left.Left(), right = right.Right();
      cross |= up | down | left | right;
    }
  }
  return crosses;
}

inline constexpr auto kCrosses = MakeCrosses();

}  // namespace internal

// The cells in the row or column of `cell` at distance <= reach, itself included; walls do not
// matter. reach >= 0.
[[nodiscard]] inline BitBoard CrossOf(Cell cell, int reach) {
  return internal::kCrosses[cell][reach < kBoardSize ? reach : kBoardSize - 1];
}

}  // namespace powderkeg

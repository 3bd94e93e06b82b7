#include "common/pommerman/blast.h"

#include <algorithm>
#include <array>

namespace powderkeg {
namespace {

constexpr int kDirectionCount = 4;
using Rays = std::array<std::array<BitBoard, kCellCount>, kDirectionCount>;

// kRays[direction - 1][cell]: all cells beyond `cell` in that direction, up to the edge.
constexpr Rays kRays = [] {
  Rays rays;
  for (int index = 0; index < kDirectionCount; ++index) {
    for (Cell from = 0; from < kCellCount; ++from) {
      const Direction direction = kDirections[index];
      for (Cell at = Neighbour(from, direction); at != kNoCell; at = Neighbour(at, direction)) {
        rays[index][from].Add(at);
      }
    }
  }
  return rays;
}();

// The cells of one ray up to and with `last` or the first wall before it. Cells behind the stop
// are exactly the stop's own ray.
template <Direction direction>
BitBoard Ray(Cell cell, Cell last, BitBoard walls) {
  const auto& rays = kRays[static_cast<int>(direction) - 1];
  BitBoard stops = rays[cell] & walls;
  stops.Add(last);
  constexpr bool kAscending = direction == Direction::kDown || direction == Direction::kRight;
  const Cell stop = kAscending ? stops.First() : stops.Last();
  return rays[cell] & ~rays[stop];
}

}  // namespace

BitBoard BlastCells(Cell cell, int strength, BitBoard rigid, BitBoard wood) {
  const int range = strength - 1;
  const int row = RowOf(cell);
  const int column = ColumnOf(cell);
  const Cell up = CellAt(std::max(row - range, 0), column);
  const Cell down = CellAt(std::min(row + range, kBoardSize - 1), column);
  const Cell left = CellAt(row, std::max(column - range, 0));
  const Cell right = CellAt(row, std::min(column + range, kBoardSize - 1));
  const BitBoard walls = rigid | wood;
  const BitBoard reached =
      Ray<Direction::kUp>(cell, up, walls) | Ray<Direction::kDown>(cell, down, walls) |
      Ray<Direction::kLeft>(cell, left, walls) | Ray<Direction::kRight>(cell, right, walls);
  return BitBoard::Of(cell) | (reached & ~rigid);
}

}  // namespace powderkeg

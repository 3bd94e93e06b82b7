#include "common/pommerman/symmetry.h"

#include <cstdint>

namespace powderkeg {
namespace {

constexpr int kMirrors = 4;  // the bit of a symmetry that mirrors
constexpr int kQuarterTurns = 4;

// Acts on offsets from the board's centre, so on directions too.
struct Offset {
  int rows;
  int columns;
};

constexpr Offset Transformed(Symmetry symmetry, Offset offset) {
  if ((symmetry & kMirrors) != 0) offset.columns = -offset.columns;
  for (int turn = symmetry % kQuarterTurns; turn > 0; --turn) {
    offset = {offset.columns, -offset.rows};
  }
  return offset;
}

using CellTable = std::array<std::array<std::uint8_t, kCellCount>, kSymmetryCount>;

constexpr CellTable kCells = [] {
  constexpr int kCentre = kBoardSize / 2;
  CellTable table{};
  for (Symmetry symmetry = 0; symmetry < kSymmetryCount; ++symmetry) {
    for (Cell cell = 0; cell < kCellCount; ++cell) {
      const Offset to = Transformed(symmetry, {RowOf(cell) - kCentre, ColumnOf(cell) - kCentre});
      table[symmetry][cell] =
          static_cast<std::uint8_t>(CellAt(to.rows + kCentre, to.columns + kCentre));
    }
  }
  return table;
}();

BitBoard TransformedSet(Symmetry symmetry, BitBoard cells) {
  BitBoard result;
  ForEachCell(cells, [&](Cell cell) { result.Add(kCells[symmetry][cell]); });
  return result;
}

}  // namespace

Cell Transform(Symmetry symmetry, Cell cell) { return kCells[symmetry][cell]; }

Direction Transform(Symmetry symmetry, Direction direction) {
  constexpr Cell kCentreCell = CellAt(kBoardSize / 2, kBoardSize / 2);
  const Cell to = Transform(symmetry, Neighbour(kCentreCell, direction));
  for (const Direction candidate : kDirections) {
    if (Neighbour(kCentreCell, candidate) == to) return candidate;
  }
  return Direction::kNone;
}

Action Transform(Symmetry symmetry, Action action) {
  return IsMove(action) ? ActionOf(Transform(symmetry, DirectionOf(action))) : action;
}

State Transform(Symmetry symmetry, const State& state) {
  State result = state;
  for (BitBoard* cells :
       {&result.rigid, &result.wood, &result.item_low, &result.item_high, &result.flames[0],
        &result.flames[1], &result.flames[2], &result.bomb_cells}) {
    *cells = TransformedSet(symmetry, *cells);
  }
  for (Bomb& bomb : result.Bombs()) {
    bomb.cell = kCells[symmetry][bomb.cell];
    bomb.set_direction(Transform(symmetry, bomb.direction()));
  }
  for (AgentState& agent : result.agents) agent.cell = kCells[symmetry][agent.cell];
  return result;
}

}  // namespace powderkeg

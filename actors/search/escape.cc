#include "actors/search/escape.h"

#include <algorithm>

#include "common/policies/cross.h"
#include "common/policies/simple_unbiased.h"

namespace powderkeg {
namespace {

BitBoard VisibleAgents(const PolicyView& view) { return view.state.AgentCells() & view.visible; }

BitBoard WalkableCells(const PolicyView& view) { return view.visible & view.state.Walkable(); }

// The cells within this distance, but for the last row, where the scan does not look.
BitBoard ScannedCells(Cell self, int distance) {
  BitBoard cells = BitBoard::Of(self);
  for (int i = 0; i < distance; ++i) cells |= cells.Neighbours();
  const int last_row = RowOf(self) + distance;
  return last_row < kBoardSize ? cells & ~BitBoard::Row(last_row) : cells;
}

std::uint16_t ColumnsNear(int column, int distance) {
  std::uint32_t columns = 0;
  const int end = std::min(column + distance, kBoardSize);
  for (int near = std::max(column - distance, 0); near < end; ++near) columns |= 1U << near;
  return static_cast<std::uint16_t>(columns);
}

}  // namespace

Escape::Escape(const PolicyView& view) {
  const Cell self = view.state.agents[static_cast<std::size_t>(view.self)].cell;
  BitBoard exploding;
  for (const Bomb& bomb : view.state.Bombs()) {
    if (!view.visible.Has(bomb.cell)) continue;
    const BitBoard cross = CrossOf(bomb.cell, bomb.blast_strength - 1);
    if (bomb.life <= 1) exploding |= cross;
    if (!cross.Has(self) || (in_danger() && bomb.life >= danger_)) continue;
    danger_ = static_cast<std::uint8_t>(bomb.life);
  }
  if (in_danger()) FindRefuges(view, exploding);
}

// Floods the board from all four neighbours of the agent at once. As in the policy's search, a cell
// belongs to the earliest move, in that search's order, with which a shortest path to it begins.
// Cells with agents may be refuges but are no way through.
void Escape::FindRefuges(const PolicyView& view, BitBoard exploding) {
  const Cell self = view.state.agents[static_cast<std::size_t>(view.self)].cell;
  const BitBoard walkable = WalkableCells(view);
  BitBoard open = (walkable | VisibleAgents(view)) & ~BitBoard::Of(self);
  const BitBoard refuges = open & ~exploding & ScannedCells(self, danger_);
  near_columns_ = ColumnsNear(ColumnOf(self), danger_);

  std::array<BitBoard, 4> fronts;
  std::array<Direction, 4> moves{};
  for (std::size_t i = 0; i < 4; ++i) {
    fronts[i] = BitBoard::Of(self).Shifted(kSearchOrder[i]) & open;
    open ^= fronts[i];
    if ((fronts[i] & walkable & ~exploding).Any()) moves[i] = kSearchOrder[i];
  }
  for (BitBoard reached = BitBoard::Of(self); reached.Any();) {
    reached = BitBoard();
    for (std::size_t i = 0; i < 4; ++i) {
      Note(fronts[i] & refuges, moves[i]);
      fronts[i] = (fronts[i] & walkable).Neighbours() & open;
      open ^= fronts[i];
      reached |= fronts[i];
    }
  }
}

void Escape::Note(BitBoard refuges, Direction move) {
  possible_ = possible_ || refuges.Any();
  ForEachCell(refuges, [&](Cell cell) {
    auto& row = refuges_[static_cast<std::size_t>(RowOf(cell))];
    row = static_cast<std::uint16_t>(row | 1U << ColumnOf(cell));
    moves_[static_cast<std::size_t>(cell)] = move;
  });
}

Direction Escape::Choose(const PolicyTraits& orders) const {
  std::uint32_t scanned = 0;
  for (const std::uint8_t column : orders.column_order) {
    if ((near_columns_ >> column & 1) == 0) break;
    scanned |= 1U << column;
  }
  for (const std::uint8_t row : orders.row_order) {
    const std::uint32_t columns = refuges_[row] & scanned;
    if (columns == 0) continue;
    for (const std::uint8_t column : orders.column_order) {
      if ((columns >> column & 1) != 0)
        return moves_[static_cast<std::size_t>(CellAt(row, column))];
    }
  }
  return Direction::kNone;
}

}  // namespace powderkeg

#include "actors/play/seat_statistics.h"

#include <algorithm>
#include <cstddef>

#include "common/pommerman/bit_board.h"

namespace powderkeg {
namespace {

template <std::size_t size>
void AddEach(const std::array<std::uint32_t, size>& from, std::array<std::uint32_t, size>& to) {
  for (std::size_t i = 0; i < size; ++i) to[i] += from[i];
}

void CountDeath(AgentId victim, AgentSet killers, Mode mode, GameStatistics& statistics) {
  if (killers == 1 << victim) ++statistics[victim].own_deaths;
  for (AgentId killer = 0; killer < kAgentCount; ++killer) {
    if (killer == victim || !Has(killers, killer)) continue;
    ++(AreEnemies(mode, killer, victim) ? statistics[killer].kills : statistics[killer].mate_kills);
  }
}

// Where `cell` is on the board mirrored so that `start` is in its top left quarter.
Cell FromTopLeft(Cell cell, Cell start, int board_size) {
  const auto mirrored = [board_size](int line, int from) {
    return 2 * from < board_size ? line : board_size - 1 - line;
  };
  return CellAt(mirrored(RowOf(cell), RowOf(start)), mirrored(ColumnOf(cell), ColumnOf(start)));
}

}  // namespace

SeatStatistics& SeatStatistics::operator+=(const SeatStatistics& other) {
  moves += other.moves;
  AddEach(other.actions, actions);
  late_moves += other.late_moves;
  searches += other.searches;
  simulations += other.simulations;
  depth_sum += other.depth_sum;
  variation_sum += other.variation_sum;
  predictions += other.predictions;
  predictions_right += other.predictions_right;
  AddEach(other.taken_for, taken_for);
  bombs += other.bombs;
  kicks += other.kicks;
  kills += other.kills;
  mate_kills += other.mate_kills;
  own_deaths += other.own_deaths;
  AddEach(other.cells, cells);
  windows += other.windows;
  window_cells += other.window_cells;
  return *this;
}

void CountEvents(const StepEvents& events, Mode mode, GameStatistics& statistics) {
  for (AgentId id = 0; id < kAgentCount; ++id) {
    statistics[id].bombs += Has(events.laid, id) ? 1 : 0;
    statistics[id].kicks += Has(events.kicked, id) ? 1 : 0;
    if (Has(events.burnt, id)) CountDeath(id, events.killers[id], mode, statistics);
  }
}

void RecentCells::Add(Cell cell) {
  if (moves_ == 0) start_ = cell;
  cells_[static_cast<std::size_t>(moves_ % kMoves)] = static_cast<std::uint8_t>(cell);
  ++moves_;
}

int RecentCells::Distinct() const {
  BitBoard cells;
  for (int i = 0; i < std::min(moves_, kMoves); ++i) cells.Add(cells_[i]);
  return cells.Count();
}

void CountCell(Cell cell, int board_size, RecentCells& recent, SeatStatistics& statistics) {
  recent.Add(cell);
  ++statistics.cells[FromTopLeft(cell, recent.start(), board_size)];
  if (!recent.full()) return;
  ++statistics.windows;
  statistics.window_cells += static_cast<std::uint64_t>(recent.Distinct());
}

}  // namespace powderkeg

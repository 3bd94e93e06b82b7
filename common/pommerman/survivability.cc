#include "common/pommerman/survivability.h"

#include <algorithm>

#include "common/pommerman/step.h"

namespace powderkeg {
namespace {

BitBoard Walls(const State& state) { return state.rigid | state.wood; }

}  // namespace

BombFuture ForeseeBombs(const GameSettings& settings, const State& state) {
  State future = state;
  for (AgentState& agent : future.agents) agent.alive = false;
  BombFuture foreseen;
  foreseen.deadly[0] = state.Flames();
  for (int step = 1; step <= kForesight; ++step) {
    const BitBoard barred = Walls(future) | future.bomb_cells;
    Step(settings, {}, future);
    Collapse(settings, future);
    foreseen.blocked[step] = barred | future.bomb_cells;
    foreseen.deadly[step] = future.Flames() | future.rigid;
  }
  foreseen.wood = future.wood;
  return foreseen;
}

CellsByStep ReachableCells(const BombFuture& future, Cell cell, const CellsByStep& taken) {
  CellsByStep reached;
  reached[0] = BitBoard::Of(cell);
  for (int step = 1; step <= kForesight; ++step) {
    const BitBoard entered = reached[step - 1].Neighbours() & ~(future.blocked[step] | taken[step]);
    reached[step] = (reached[step - 1] | entered) & ~future.deadly[step];
  }
  return reached;
}

CellsByStep ReachableCells(const BombFuture& future, Cell cell, int steps) {
  CellsByStep reached;
  reached[0] = BitBoard::Of(cell);
  for (int step = 1; step <= kForesight; ++step) {
    reached[step] = reached[step - 1];
    if (step > steps) continue;
    reached[step] |= reached[step - 1].Neighbours() & ~future.blocked[step];
    reached[step] &= ~future.deadly[step];
  }
  return reached;
}

CellsByStep SurvivableCells(const BombFuture& future, Cell cell, const CellsByStep& taken) {
  CellsByStep cells = ReachableCells(future, cell, taken);
  for (int step = kForesight; step > 0; --step) {
    const BitBoard enterable = cells[step] & ~(future.blocked[step] | taken[step]);
    cells[step - 1] &= cells[step] | enterable.Neighbours();
  }
  return cells;
}

CellsByStep CellsOf(const BombFuture& future, const State& state, AgentSet everywhere, int spread,
                    AgentSet there) {
  CellsByStep cells{};
  for (std::size_t id = 0; id < kAgentCount; ++id) {
    const bool moves = Has(everywhere, id);
    if ((!moves && !Has(there, id)) || !state.agents[id].alive) continue;
    const CellsByStep reached = ReachableCells(future, state.agents[id].cell, moves ? spread : 0);
    for (std::size_t step = 0; step < cells.size(); ++step) cells[step] |= reached[step];
  }
  return cells;
}

int CountPairs(const CellsByStep& cells) {
  int pairs = 0;
  for (int step = 1; step <= kForesight; ++step) pairs += cells[step].Count();
  return pairs;
}

bool FutureMemory::Fits(const Entry& entry, const State& state) {
  return entry.bomb_count == state.bomb_count && entry.step == state.step &&
         std::equal(entry.bombs.begin(), entry.bombs.begin() + entry.bomb_count,
                    state.bombs.begin()) &&
         entry.wood == state.wood && entry.items == state.VisibleItems();
}

const BombFuture& FutureMemory::For(const GameSettings& settings, const State& state) {
  const std::size_t kept = std::min(count_, kSize);
  for (std::size_t i = 0; i < kept; ++i) {
    if (Fits(entries_[i], state)) return entries_[i].future;
  }
  Entry& entry = entries_[count_++ % kSize];
  entry.bombs = state.bombs;
  entry.bomb_count = state.bomb_count;
  entry.step = state.step;
  entry.wood = state.wood;
  entry.items = state.VisibleItems();
  entry.future = ForeseeBombs(settings, state);
  return entry.future;
}

}  // namespace powderkeg

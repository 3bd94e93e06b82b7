#pragma once

// Where an agent can still live in the next steps: sets of cells by step, worked out on bit boards.

#include <array>
#include <cstddef>

#include "common/pommerman/bit_board.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"

namespace powderkeg {

// Steps looked ahead. A bomb laid in the step just played has exploded and burnt out by then.
inline constexpr int kForesight = 12;
// Sets after 0 (now), 1, ..., kForesight more steps.
using CellsByStep = std::array<BitBoard, kForesight + 1>;

// What the bombs, flames and the collapse of a position come to if nobody touches anything: bombs
// tick, roll on over agents as if those were not there, and set each other off; wood burns; what
// wood hides is not known and bars no way. Shared by all agents of the position.
struct BombFuture {
  CellsByStep deadly;   // flames and walls: whoever is there after the step is dead
  CellsByStep blocked;  // cannot be entered in the step (of index 0: nothing is said)
  BitBoard wood;        // that is left at the end
};
[[nodiscard]] BombFuture ForeseeBombs(const GameSettings& settings, const State& state);

// The cells in which an agent that is on `cell` now can be after each step, alive. It walks or
// waits; it lays and kicks nothing. In step t it enters no cell of taken[t], where somebody else
// may be by then; who stands in one already stays.
[[nodiscard]] CellsByStep ReachableCells(const BombFuture& future, Cell cell,
                                         const CellsByStep& taken);
// The same for its first `steps` steps; from then on it stays within reach.
[[nodiscard]] CellsByStep ReachableCells(const BombFuture& future, Cell cell, int steps);

// Of the reachable cells those from which the agent can live to the end of the foresight: empty in
// every step if there is no way out. Exact for an agent that is alone with bombs at rest.
[[nodiscard]] CellsByStep SurvivableCells(const BombFuture& future, Cell cell,
                                          const CellsByStep& taken);

// Where others may be in the way: those of `everywhere` in all cells that they can reach in
// `spread` steps, those of `there` where they are. Agents that died are nowhere.
[[nodiscard]] CellsByStep CellsOf(const BombFuture& future, const State& state, AgentSet everywhere,
                                  int spread, AgentSet there);

// The (cell, step) pairs after at least one step: the survivability of Osogami and Takahashi
// (arXiv 1902.10870), at most kForesight * kCellCount.
[[nodiscard]] int CountPairs(const CellsByStep& cells);

// The futures of a decision's positions: few, as most moves leave the bombs as they are.
class FutureMemory {
 public:
  // To be called where other settings hold.
  void Clear() { count_ = 0; }
  // Valid until the next call.
  [[nodiscard]] const BombFuture& For(const GameSettings& settings, const State& state);

 private:
  static constexpr std::size_t kSize = 64;
  struct Entry {
    std::array<Bomb, kMaxBombs> bombs;
    int bomb_count;
    int step;
    BitBoard wood;
    BitBoard items;
    BombFuture future;
  };
  [[nodiscard]] static bool Fits(const Entry& entry, const State& state);

  std::array<Entry, kSize> entries_;
  std::size_t count_ = 0;
};

}  // namespace powderkeg

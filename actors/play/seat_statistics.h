#pragma once

// What happened at one seat of a game, in numbers.

#include <array>
#include <cstdint>

#include "actors/play/step_events.h"
#include "common/config/search_settings.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/types.h"

namespace powderkeg {

// Sums over a game, or over several.
struct SeatStatistics {
  std::uint32_t moves = 0;  // steps in which the agent lived
  std::array<std::uint32_t, kActionCount> actions{};
  std::uint32_t late_moves = 0;  // MoveStatistics::late
  std::uint32_t searches = 0;    // moves with simulations
  std::uint64_t simulations = 0;
  double depth_sum = 0;             // of the mean depths, over `searches`
  std::uint64_t variation_sum = 0;  // of the lengths of the principal variations
  std::uint32_t predictions = 0;    // opponents' actions predicted at the root
  std::uint32_t predictions_right = 0;
  std::array<std::uint32_t, kOpponentModelCount> taken_for{};  // predictions by OpponentModel

  std::uint32_t bombs = 0;  // laid
  std::uint32_t kicks = 0;  // bombs set rolling
  // Enemies, and mates, that died in flames of its bombs; where flames of several agents met, each
  // of them counts the death, but for the victim.
  std::uint32_t kills = 0;
  std::uint32_t mate_kills = 0;
  std::uint32_t own_deaths = 0;  // in flames of its own bombs alone

  // Moves made on each cell of the board, mirrored so that the agent started top left; sum: moves.
  std::array<std::uint32_t, kCellCount> cells{};
  std::uint32_t windows = 0;       // runs of RecentCells::kMoves moves, overlapping
  std::uint64_t window_cells = 0;  // distinct cells in each, summed

  SeatStatistics& operator+=(const SeatStatistics& other);
};

// By agent id.
using GameStatistics = std::array<SeatStatistics, kAgentCount>;

// Counts bombs, kicks and deaths of one step.
void CountEvents(const StepEvents& events, Mode mode, GameStatistics& statistics);

// The cells of an agent's first and last moves. A value.
class RecentCells {
 public:
  static constexpr int kMoves = 20;

  void Add(Cell cell);
  // Whether there were kMoves moves yet.
  [[nodiscard]] bool full() const { return moves_ >= kMoves; }
  // Distinct cells among the last kMoves moves.
  [[nodiscard]] int Distinct() const;
  // Where the first move was made. Requires one.
  [[nodiscard]] Cell start() const { return start_; }

 private:
  std::array<std::uint8_t, kMoves> cells_{};  // a ring
  Cell start_ = kNoCell;
  int moves_ = 0;
};

// Counts a move made on `cell`: there, and in the window that it completes.
void CountCell(Cell cell, int board_size, RecentCells& recent, SeatStatistics& statistics);

}  // namespace powderkeg

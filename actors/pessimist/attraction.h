#pragma once

// Where the pessimist goes when nothing else matters.

#include <array>

#include "common/pommerman/bit_board.h"
#include "common/pommerman/types.h"

namespace powderkeg {

// How much each cell is worth to be on: the best over the goals of the goal's worth, less one for
// each step of the way to it. 0 where no goal is near enough. A value.
class Attraction {
 public:
  static constexpr int kMostWorth = 40;

  // Goals within these cells are worth `worth`, at most kMostWorth.
  void Add(BitBoard goals, int worth) { goals_[static_cast<std::size_t>(worth)] |= goals; }
  // Once all goals are known. Ways lead through `open`.
  void Spread(BitBoard open);

  [[nodiscard]] int At(Cell cell) const { return worth_[static_cast<std::size_t>(cell)]; }

 private:
  std::array<BitBoard, kMostWorth + 1> goals_{};
  std::array<std::uint8_t, kCellCount> worth_{};
};

}  // namespace powderkeg

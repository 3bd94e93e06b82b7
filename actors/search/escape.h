#pragma once

// How a SimpleUnbiased agent in danger chooses its refuge: the first rule of the policy, solved for
// all orders of rows and columns at once.

#include <array>
#include <cstdint>

#include "common/policies/policy.h"
#include "common/pommerman/bit_board.h"
#include "common/pommerman/types.h"

namespace powderkeg {

// Made of one view in the time of a few decisions; then Choose takes a small part of one. A value
// of 148 bytes.
class Escape {
 public:
  // Not in danger.
  Escape() = default;
  // The escape of view.self, which must be alive.
  explicit Escape(const PolicyView& view);

  // Whether a bomb that the agent sees threatens its cell; if so, the order of agents has no say.
  [[nodiscard]] bool in_danger() const { return danger_ > 0; }
  // Whether there is any refuge in reach; else Choose is kNone for all orders.
  [[nodiscard]] bool possible() const { return possible_; }

  // The move of an agent with these orders; kNone if its scan finds no safe one, and it goes on
  // with the rules for items and for wandering.
  [[nodiscard]] Direction Choose(const PolicyTraits& orders) const;

 private:
  void FindRefuges(const PolicyView& view, BitBoard exploding);
  void Note(BitBoard refuges, Direction move);

  std::array<std::uint16_t, kBoardSize> refuges_{};  // by row; bit `column`
  std::array<Direction, kCellCount> moves_{};        // towards a refuge; kNone if not safe
  std::uint16_t near_columns_ = 0;                   // the scan leaves a row at any other
  std::uint8_t danger_ = 0;  // steps until the first explosion that covers the own cell; 0: none
  bool possible_ = false;
};

}  // namespace powderkeg

#pragma once

// A set of cells in two machine words.

#include <bit>
#include <cstdint>

#include "common/pommerman/types.h"

namespace powderkeg {

namespace internal {

__extension__ typedef unsigned __int128 CellWord;

// All cells but those of a column.
constexpr CellWord WithoutColumn(int column) {
  CellWord cells = (CellWord{1} << kCellCount) - 1;
  for (int row = 0; row < kBoardSize; ++row) cells &= ~(CellWord{1} << CellAt(row, column));
  return cells;
}

}  // namespace internal

// A subset of the 121 cells; bit `cell` of the 128. A trivially copyable value. Shift results are
// clipped to the board: nothing wraps from one row's end to the next row's start.
class BitBoard {
 public:
  constexpr BitBoard() = default;
  [[nodiscard]] static constexpr BitBoard Of(Cell cell) { return BitBoard(Word{1} << cell); }
  [[nodiscard]] static constexpr BitBoard All() { return BitBoard((Word{1} << kCellCount) - 1); }
  // All cells with this column.
  [[nodiscard]] static constexpr BitBoard Column(int column) {
    Word bits = 0;
    for (int row = 0; row < kBoardSize; ++row) bits |= Word{1} << CellAt(row, column);
    return BitBoard(bits);
  }
  [[nodiscard]] static constexpr BitBoard Row(int row) {
    return BitBoard(((Word{1} << kBoardSize) - 1) << CellAt(row, 0));
  }

  [[nodiscard]] constexpr bool Has(Cell cell) const {
    return ((cell < 64 ? low_ >> cell : high_ >> (cell - 64)) & 1) != 0;
  }
  constexpr void Add(Cell cell) { (cell < 64 ? low_ : high_) |= std::uint64_t{1} << (cell & 63); }
  constexpr void Remove(Cell cell) {
    (cell < 64 ? low_ : high_) &= ~(std::uint64_t{1} << (cell & 63));
  }
  // The cells of a row, bit `column` each.
  [[nodiscard]] constexpr std::uint32_t ColumnsOf(int row) const {
    return static_cast<std::uint32_t>(bits() >> CellAt(row, 0)) & ((1U << kBoardSize) - 1);
  }
  [[nodiscard]] constexpr bool Empty() const { return (low_ | high_) == 0; }
  [[nodiscard]] constexpr bool Any() const { return (low_ | high_) != 0; }
  [[nodiscard]] constexpr int Count() const { return std::popcount(low_) + std::popcount(high_); }
  // The lowest cell. Requires Any().
  [[nodiscard]] constexpr Cell First() const {
    return low_ != 0 ? std::countr_zero(low_) : 64 + std::countr_zero(high_);
  }
  // The highest cell. Requires Any().
  [[nodiscard]] constexpr Cell Last() const {
    return high_ != 0 ? 127 - std::countl_zero(high_) : 63 - std::countl_zero(low_);
  }
  // Removes and returns the lowest cell. Requires Any().
  constexpr Cell PopFirst() {
    const Cell cell = First();
    if (low_ != 0) {
      low_ &= low_ - 1;
    } else {
      high_ &= high_ - 1;
    }
    return cell;
  }

  // Every cell moved by one; what leaves the board is gone.
  [[nodiscard]] constexpr BitBoard Up() const { return BitBoard(bits() >> kBoardSize); }
  [[nodiscard]] constexpr BitBoard Down() const { return BitBoard(bits() << kBoardSize) & All(); }
  [[nodiscard]] constexpr BitBoard Left() const {
    return BitBoard(bits() >> 1) & BitBoard(kNotLastColumn);
  }
  [[nodiscard]] constexpr BitBoard Right() const {
    return BitBoard(bits() << 1) & BitBoard(kNotFirstColumn);
  }
  [[nodiscard]] constexpr BitBoard Shifted(Direction direction) const {
    switch (direction) {
      case Direction::kUp: return Up();
      case Direction::kDown: return Down();
      case Direction::kLeft: return Left();
      case Direction::kRight: return Right();
      case Direction::kNone: break;
    }
    return *this;
  }
  // The four neighbours of every cell, without the cells themselves unless they are neighbours.
  [[nodiscard]] constexpr BitBoard Neighbours() const { return Up() | Down() | Left() | Right(); }

  friend constexpr BitBoard operator&(BitBoard a, BitBoard b) {
    return BitBoard(a.low_ & b.low_, a.high_ & b.high_);
  }
  friend constexpr BitBoard operator|(BitBoard a, BitBoard b) {
    return BitBoard(a.low_ | b.low_, a.high_ | b.high_);
  }
  friend constexpr BitBoard operator^(BitBoard a, BitBoard b) {
    return BitBoard(a.low_ ^ b.low_, a.high_ ^ b.high_);
  }
  // The complement within the board.
  friend constexpr BitBoard operator~(BitBoard a) {
    return BitBoard(~a.low_, ~a.high_ & kHighMask);
  }
  constexpr BitBoard& operator&=(BitBoard b) { return *this = *this & b; }
  constexpr BitBoard& operator|=(BitBoard b) { return *this = *this | b; }
  constexpr BitBoard& operator^=(BitBoard b) { return *this = *this ^ b; }
  friend constexpr bool operator==(BitBoard, BitBoard) = default;

  [[nodiscard]] constexpr std::uint64_t low() const { return low_; }
  [[nodiscard]] constexpr std::uint64_t high() const { return high_; }

 private:
  using Word = internal::CellWord;
  static constexpr Word kNotFirstColumn = internal::WithoutColumn(0);
  static constexpr Word kNotLastColumn = internal::WithoutColumn(kBoardSize - 1);
  static constexpr std::uint64_t kHighMask = (std::uint64_t{1} << (kCellCount - 64)) - 1;

  explicit constexpr BitBoard(Word bits)
      : low_(static_cast<std::uint64_t>(bits)), high_(static_cast<std::uint64_t>(bits >> 64)) {}
  constexpr BitBoard(std::uint64_t low, std::uint64_t high) : low_(low), high_(high) {}
  [[nodiscard]] constexpr Word bits() const { return Word{high_} << 64 | low_; }

  std::uint64_t low_ = 0;
  std::uint64_t high_ = 0;
};

// Calls visit(cell) for every cell of the set, ascending.
template <typename Visit>
constexpr void ForEachCell(BitBoard cells, Visit&& visit) {
  while (cells.Any()) visit(cells.PopFirst());
}

}  // namespace powderkeg

#pragma once

// The vocabulary of the game: cells, directions, actions, agents.

#include <array>
#include <cstddef>
#include <cstdint>

namespace powderkeg {

inline constexpr int kBoardSize = 11;
inline constexpr int kCellCount = kBoardSize * kBoardSize;
inline constexpr int kAgentCount = 4;
inline constexpr int kActionCount = 6;

// 0..3, in the official order (corners counter-clockwise from the top left).
using AgentId = int;

// row * 11 + column, 0..120; row 0 at the top. One-against-one boards (8x8) use the top left part
// of the same 11x11 grid; the rest is rigid.
using Cell = int;
inline constexpr Cell kNoCell = -1;

[[nodiscard]] constexpr Cell CellAt(int row, int column) { return row * kBoardSize + column; }
[[nodiscard]] constexpr int RowOf(Cell cell) { return cell / kBoardSize; }
[[nodiscard]] constexpr int ColumnOf(Cell cell) { return cell % kBoardSize; }

// Values are the official action numbers.
enum class Action : std::uint8_t {
  kStop = 0,
  kUp = 1,
  kDown = 2,
  kLeft = 3,
  kRight = 4,
  kBomb = 5
};

inline constexpr std::array<const char*, kActionCount> kActionNames = {"stop", "up",    "down",
                                                                       "left", "right", "bomb"};

// A set of agents; bit i is agent i.
using AgentSet = std::uint8_t;

// Whether a set of agents or actions, bit i for number i, holds this one.
[[nodiscard]] constexpr bool Has(std::uint8_t set, std::size_t number) {
  return (set >> number & 1) != 0;
}

// Values are the official directions of moving bombs, equal to those of the actions.
enum class Direction : std::uint8_t { kNone = 0, kUp = 1, kDown = 2, kLeft = 3, kRight = 4 };

inline constexpr std::array<Direction, 4> kDirections = {Direction::kUp, Direction::kDown,
                                                         Direction::kLeft, Direction::kRight};

[[nodiscard]] constexpr bool IsMove(Action action) {
  return action != Action::kStop && action != Action::kBomb;
}
// kNone for stop and bomb.
[[nodiscard]] constexpr Direction DirectionOf(Action action) {
  return IsMove(action) ? static_cast<Direction>(action) : Direction::kNone;
}
[[nodiscard]] constexpr Action ActionOf(Direction direction) {
  return static_cast<Action>(direction);
}

// The neighbour of `cell`, or kNoCell beyond the edge of the 11x11 grid. kNone gives the cell
// itself.
[[nodiscard]] constexpr Cell Neighbour(Cell cell, Direction direction) {
  switch (direction) {
    case Direction::kNone: return cell;
    case Direction::kUp: return cell >= kBoardSize ? cell - kBoardSize : kNoCell;
    case Direction::kDown: return cell < kCellCount - kBoardSize ? cell + kBoardSize : kNoCell;
    case Direction::kLeft: return ColumnOf(cell) > 0 ? cell - 1 : kNoCell;
    case Direction::kRight: return ColumnOf(cell) < kBoardSize - 1 ? cell + 1 : kNoCell;
  }
  return kNoCell;
}

namespace internal {
inline constexpr auto kNeighbourOrSelf = [] {
  std::array<std::array<std::uint8_t, kCellCount>, kActionCount> table{};
  for (int direction = 0; direction < kActionCount; ++direction) {
    for (Cell cell = 0; cell < kCellCount; ++cell) {
      const bool moves = direction <= static_cast<int>(Direction::kRight);
      const Cell next = moves ? Neighbour(cell, static_cast<Direction>(direction)) : cell;
      table[direction][cell] = static_cast<std::uint8_t>(next == kNoCell ? cell : next);
    }
  }
  return table;
}();
}  // namespace internal

// As Neighbour, but `cell` itself beyond the edge. One look-up.
[[nodiscard]] constexpr Cell NeighbourOrSelf(Cell cell, Direction direction) {
  return internal::kNeighbourOrSelf[static_cast<int>(direction)][cell];
}
// The cell that an action aims at; stop, bomb and a move off the board aim at `cell` itself.
[[nodiscard]] constexpr Cell TargetOf(Cell cell, Action action) {
  return internal::kNeighbourOrSelf[static_cast<int>(action)][cell];
}

[[nodiscard]] constexpr int ManhattanDistance(Cell a, Cell b) {
  const int rows = RowOf(a) - RowOf(b);
  const int columns = ColumnOf(a) - ColumnOf(b);
  return (rows < 0 ? -rows : rows) + (columns < 0 ? -columns : columns);
}

// One action per agent id; those of dead agents are ignored.
using JointAction = std::array<Action, kAgentCount>;

// What the official board shows in a cell; values are the official ones.
enum class CellValue : std::uint8_t {
  kPassage = 0,
  kRigid = 1,
  kWood = 2,
  kBomb = 3,
  kFlames = 4,
  kFog = 5,
  kExtraBomb = 6,
  kIncreaseRange = 7,
  kKick = 8,
  kAgentDummy = 9,
  kAgent0 = 10,  // agent i is kAgent0 + i
};

[[nodiscard]] constexpr CellValue AgentValue(AgentId id) {
  return static_cast<CellValue>(static_cast<int>(CellValue::kAgent0) + id);
}

enum class Item : std::uint8_t { kNone = 0, kExtraBomb = 1, kIncreaseRange = 2, kKick = 3 };

// Two words an agent tells its team mate (radio mode); (0, 0) when it said nothing.
using Message = std::array<std::uint8_t, 2>;

}  // namespace powderkeg

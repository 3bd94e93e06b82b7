#pragma once

// The complete position of a game as one small value.

#include <array>
#include <cstdint>
#include <span>
#include <type_traits>

#include "common/base/check.h"
#include "common/pommerman/bit_board.h"
#include "common/pommerman/types.h"

namespace powderkeg {

inline constexpr int kMaxAmmo = 10;
// Of a bomb laid in the step just played.
inline constexpr int kFreshBombLife = 9;

struct AgentState {
  std::uint8_t cell = 0;            // a dead agent keeps the cell it died on
  std::uint8_t ammo = 1;            // bombs it may lay now, 0..kMaxAmmo
  std::uint8_t blast_strength = 2;  // official strength: own cell and strength - 1 to each side
  bool alive = false;
  bool can_kick = false;

  friend bool operator==(const AgentState&, const AgentState&) = default;
};

// Four bytes. At most one bomb lies on a cell.
struct Bomb {
  std::uint8_t cell = 0;
  std::int8_t life = 0;             // steps to the explosion as stored after a step
  std::uint8_t blast_strength = 2;  // fixed when laid
  std::uint8_t owner_and_direction = 0;

  [[nodiscard]] constexpr AgentId owner() const { return owner_and_direction & 3; }
  [[nodiscard]] constexpr Direction direction() const {
    return static_cast<Direction>(owner_and_direction >> 2);
  }
  constexpr void set_owner(AgentId owner) {
    owner_and_direction = static_cast<std::uint8_t>((owner_and_direction & ~3) | owner);
  }
  constexpr void set_direction(Direction direction) {
    owner_and_direction =
        static_cast<std::uint8_t>((owner_and_direction & 3) | static_cast<int>(direction) << 2);
  }
  friend bool operator==(const Bomb&, const Bomb&) = default;
};

// A bomb lives nine steps on the board and an agent lays at most one a step, so 40 always suffice
// for positions that play can reach; in others an agent lays none beyond that.
inline constexpr int kMaxBombs = 40;

// Everything the rules look at. Trivially copyable: a copy is a snapshot. Equality compares every
// field of the game; flames are sets by remaining life (their list order never matters).
//
// Invariants: bomb_cells is the set of the bombs' cells; unused bombs are default values; an item
// on a wood or flame cell is hidden, any other item is visible and can be picked up; rigid, wood
// and visible items never overlap; no living agent or bomb stands in flames between steps.
struct State {
  BitBoard rigid;
  BitBoard wood;
  // The item in a cell is (item_high bit, item_low bit) read as the number of enum Item.
  BitBoard item_low;
  BitBoard item_high;
  // flames[life]: cells with a flame of that life (2 when made, gone in the step after 0). A cell
  // may be in several.
  std::array<BitBoard, 3> flames;
  BitBoard bomb_cells;
  std::array<Bomb, kMaxBombs> bombs;  // [0, bomb_count), in the order in which they were laid
  std::array<AgentState, kAgentCount> agents;
  // The words each agent sent in the step just played (radio mode), else (0, 0).
  std::array<Message, kAgentCount> messages{};
  std::uint16_t step = 0;  // steps played, 0..800
  std::uint8_t bomb_count = 0;

  [[nodiscard]] std::span<const Bomb> Bombs() const { return {bombs.data(), bomb_count}; }
  [[nodiscard]] std::span<Bomb> Bombs() { return {bombs.data(), bomb_count}; }
  [[nodiscard]] BitBoard Flames() const { return flames[0] | flames[1] | flames[2]; }
  [[nodiscard]] BitBoard Items() const { return item_low | item_high; }
  [[nodiscard]] BitBoard HiddenItems() const { return Items() & (wood | Flames()); }
  [[nodiscard]] BitBoard VisibleItems() const { return Items() & ~(wood | Flames()); }
  // The item stored for the cell, hidden or visible.
  [[nodiscard]] Item ItemAt(Cell cell) const {
    return static_cast<Item>((item_high.Has(cell) ? 2 : 0) + (item_low.Has(cell) ? 1 : 0));
  }
  void SetItem(Cell cell, Item item);
  void RemoveItems(BitBoard cells) {
    item_low &= ~cells;
    item_high &= ~cells;
  }
  // Appends at the end of the list. Requires bomb_count < kMaxBombs and no bomb on the cell.
  void AddBomb(const Bomb& bomb);
  // Takes the bombs on these cells off the list; the others keep their order.
  void RemoveBombs(BitBoard cells);
  // The bomb on the cell, or nullptr.
  [[nodiscard]] const Bomb* BombAt(Cell cell) const;
  // Cells of living agents.
  [[nodiscard]] BitBoard AgentCells() const;
  // Passages and visible items: no wall, wood, bomb, flame or living agent.
  [[nodiscard]] BitBoard Walkable() const;
  // What the official board shows (full view); an agent hides the bomb below it.
  [[nodiscard]] CellValue ValueAt(Cell cell) const;

  friend bool operator==(const State&, const State&) = default;
};

static_assert(std::is_trivially_copyable_v<State>);
static_assert(sizeof(State) <= 384);

}  // namespace powderkeg

#include "common/pommerman/generate.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace powderkeg {
namespace {

// How much of everything a board holds.
struct Amounts {
  int rigid;
  int wood;
  int items;
};

Amounts AmountsFor(Mode mode) {
  return mode == Mode::kOneVsOne ? Amounts{16, 16, 10} : Amounts{36, 36, 20};
}

// The official generator accepts boards with at most this many passages out of reach.
constexpr int kMaxUnreached = 4;

// The square of cells in play: the top left size x size cells.
BitBoard Square(int size) {
  BitBoard square;
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) square.Add(CellAt(row, column));
  }
  return square;
}

// One corner of the board: where the agent starts and how the board goes on from there.
struct Corner {
  int row;
  int column;
  int row_step;
  int column_step;

  [[nodiscard]] Cell cell() const { return CellAt(row, column); }
  // The cell `rows` and `columns` further into the board.
  [[nodiscard]] Cell Inwards(int rows, int columns) const {
    return CellAt(row + rows * row_step, column + columns * column_step);
  }
};

// In agent order: counter-clockwise from the top left; the two on the diagonal for two agents.
std::vector<Corner> Corners(const GameSettings& settings) {
  const int last = settings.board_size - 2;
  const Corner top_left = {1, 1, 1, 1};
  const Corner bottom_left = {last, 1, -1, 1};
  const Corner bottom_right = {last, last, -1, -1};
  const Corner top_right = {1, last, 1, -1};
  if (settings.mode == Mode::kOneVsOne) return {top_left, bottom_right};
  return {top_left, bottom_left, bottom_right, top_right};
}

// The starts and the two cells next to each along both borders: never walls or wood.
BitBoard BreathingRoom(std::span<const Corner> corners) {
  BitBoard room;
  for (const Corner& corner : corners) {
    room.Add(corner.cell());
    for (int distance = 1; distance <= 2; ++distance) {
      room.Add(corner.Inwards(distance, 0));
      room.Add(corner.Inwards(0, distance));
    }
  }
  return room;
}

// The wood between neighbouring corners that every four-player board has.
BitBoard SideWood(int size) {
  BitBoard wood;
  for (int i = 4; i <= size - 5; ++i) {
    wood.Add(CellAt(1, i));
    wood.Add(CellAt(i, 1));
    wood.Add(CellAt(size - 2, i));
    wood.Add(CellAt(i, size - 2));
  }
  return wood;
}

Cell Mirrored(Cell cell) { return CellAt(ColumnOf(cell), RowOf(cell)); }

// A uniformly random cell of the set. Requires cells.Any().
Cell Draw(BitBoard cells, Rng& rng) {
  for (std::uint32_t skip = rng.Below(static_cast<std::uint32_t>(cells.Count())); skip > 0;
       --skip) {
    cells.PopFirst();
  }
  return cells.First();
}

// Moves `count` cells from the candidates to the result, each with its mirror image.
BitBoard DrawPairs(int count, BitBoard& candidates, Rng& rng) {
  BitBoard drawn;
  for (; count > 0; count -= 2) {
    const Cell cell = Draw(candidates, rng);
    for (const Cell taken : {cell, Mirrored(cell)}) {
      drawn.Add(taken);
      candidates.Remove(taken);
    }
  }
  return drawn;
}

BitBoard DrawCells(int count, BitBoard& candidates, Rng& rng) {
  BitBoard drawn;
  for (; count > 0; --count) {
    const Cell cell = Draw(candidates, rng);
    drawn.Add(cell);
    candidates.Remove(cell);
  }
  return drawn;
}

// All cells connected with `from` through open ones.
BitBoard Flood(Cell from, BitBoard open) {
  BitBoard reached = BitBoard::Of(from);
  for (BitBoard before; before != reached;) {
    before = reached;
    reached |= reached.Neighbours() & open;
  }
  return reached;
}

struct Walls {
  BitBoard rigid;
  BitBoard wood;
};

// Rules 2.1 to 2.5: one attempt, symmetric about the main diagonal.
Walls DrawOfficialWalls(const GameSettings& settings, std::span<const Corner> corners, Rng& rng) {
  const Amounts amounts = AmountsFor(settings.mode);
  BitBoard candidates = Square(settings.board_size) & ~BreathingRoom(corners);
  for (int i = 0; i < settings.board_size; ++i) candidates.Remove(CellAt(i, i));
  const BitBoard side_wood =
      settings.mode == Mode::kOneVsOne ? BitBoard() : SideWood(settings.board_size);
  candidates &= ~side_wood;
  Walls walls;
  walls.rigid = DrawPairs(amounts.rigid, candidates, rng);
  walls.wood = side_wood | DrawPairs(amounts.wood - side_wood.Count(), candidates, rng);
  return walls;
}

// Rule 2.6. Wood counts as open.
bool AcceptsOfficially(const GameSettings& settings, const Walls& walls) {
  const BitBoard open = Square(settings.board_size) & ~walls.rigid;
  const Cell from = CellAt(settings.board_size - 2, settings.board_size - 2);
  return (open & ~walls.wood & ~Flood(from, open)).Count() <= kMaxUnreached;
}

// One attempt of the uniform generator: as many cells of each kind, without symmetry.
Walls DrawUniformWalls(const GameSettings& settings, std::span<const Corner> corners, Rng& rng) {
  const Amounts amounts = AmountsFor(settings.mode);
  BitBoard candidates = Square(settings.board_size) & ~BreathingRoom(corners);
  Walls walls;
  walls.rigid = DrawCells(amounts.rigid, candidates, rng);
  walls.wood = DrawCells(amounts.wood, candidates, rng);
  return walls;
}

// Whether the agents can get to each other, through wood if need be.
bool Connects(const GameSettings& settings, std::span<const Corner> corners, const Walls& walls) {
  const BitBoard reached =
      Flood(corners.front().cell(), Square(settings.board_size) & ~walls.rigid);
  return std::ranges::all_of(corners,
                             [&](const Corner& corner) { return reached.Has(corner.cell()); });
}

Walls DrawWalls(const GameSettings& settings, BoardGenerator generator,
                std::span<const Corner> corners, Rng& rng) {
  while (true) {
    if (generator == BoardGenerator::kOfficial) {
      const Walls walls = DrawOfficialWalls(settings, corners, rng);
      if (AcceptsOfficially(settings, walls)) return walls;
    } else {
      const Walls walls = DrawUniformWalls(settings, corners, rng);
      if (Connects(settings, corners, walls)) return walls;
    }
  }
}

// Rule 2.7: distinct cells of wood, each item of a uniformly random kind.
void HideItems(int count, Rng& rng, State& state) {
  BitBoard candidates = state.wood;
  for (; count > 0; --count) {
    const Cell cell = Draw(candidates, rng);
    candidates.Remove(cell);
    state.SetItem(cell, static_cast<Item>(1 + rng.Below(3)));
  }
}

void PlaceAgents(StartCorners order, std::span<Corner> corners, Rng& rng, State& state) {
  if (order == StartCorners::kPermuted) rng.Shuffle(corners);
  for (std::size_t id = 0; id < corners.size(); ++id) {
    state.agents[id].cell = static_cast<std::uint8_t>(corners[id].cell());
    state.agents[id].alive = true;
  }
}

}  // namespace

State GenerateStart(const GameSettings& settings, const StartSettings& start, Rng rng) {
  CHECK(settings.board_size == (settings.mode == Mode::kOneVsOne ? 8 : kBoardSize),
        settings.board_size);
  std::vector<Corner> corners = Corners(settings);
  const Walls walls = DrawWalls(settings, start.generator, corners, rng);
  State state;
  state.rigid = walls.rigid | ~Square(settings.board_size);
  state.wood = walls.wood;
  HideItems(AmountsFor(settings.mode).items, rng, state);
  PlaceAgents(start.corners, corners, rng, state);
  return state;
}

}  // namespace powderkeg

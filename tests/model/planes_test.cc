#include "common/model/planes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "tests/model/positions.h"

namespace powderkeg {
namespace {

using Planes = std::array<float, kPlanesSize>;

Planes Encode(const State& state, AgentId viewer, BitBoard visible = BitBoard::All()) {
  Planes planes;
  planes.fill(99.0F);  // whatever was there before
  EncodePlanes(GameSettings{}, {.state = &state, .viewer = viewer, .visible = visible}, planes);
  return planes;
}

float At(const Planes& planes, int plane, Cell cell) {
  return planes[static_cast<std::size_t>(plane * kCellCount + cell)];
}

// The cells of a plane that are not 0.
BitBoard CellsOf(const Planes& planes, int plane) {
  BitBoard cells;
  for (Cell cell = 0; cell < kCellCount; ++cell) {
    if (At(planes, plane, cell) != 0.0F) cells.Add(cell);
  }
  return cells;
}

// The value of a plane that is constant over the board.
float ConstantOf(const Planes& planes, int plane) {
  const float value = At(planes, plane, 0);
  for (Cell cell = 0; cell < kCellCount; ++cell) EXPECT_EQ(At(planes, plane, cell), value) << plane;
  return value;
}

// The direction that planes 7 and 8 tell.
Direction MotionAt(const Planes& planes, Cell cell) {
  const float horizontal = At(planes, 7, cell);
  const float vertical = At(planes, 8, cell);
  if (horizontal != 0.0F) return horizontal < 0.0F ? Direction::kLeft : Direction::kRight;
  if (vertical != 0.0F) return vertical < 0.0F ? Direction::kDown : Direction::kUp;
  return Direction::kNone;
}

State WithBomb(Cell cell, int life, int strength, AgentId owner, Direction direction) {
  State state;
  Bomb bomb{.cell = static_cast<std::uint8_t>(cell),
            .life = static_cast<std::int8_t>(life),
            .blast_strength = static_cast<std::uint8_t>(strength)};
  bomb.set_owner(owner);
  bomb.set_direction(direction);
  state.AddBomb(bomb);
  return state;
}

TEST(Planes, EmptyBoardIsZeroButForTheViewersReach) {
  State state;
  const Planes planes = Encode(state, 0);
  for (int plane = 0; plane < kPlaneCount; ++plane) {
    const bool own_statistics = plane == 14 || plane == 16;  // reach 1, capacity 1
    EXPECT_EQ(CellsOf(planes, plane), own_statistics ? BitBoard::All() : BitBoard()) << plane;
  }
}

TEST(Planes, WallsAndWood) {
  State state;
  state.rigid.Add(0);
  state.rigid.Add(120);
  state.wood.Add(64);
  const Planes planes = Encode(state, 0);
  EXPECT_EQ(CellsOf(planes, 0), state.rigid);
  EXPECT_EQ(CellsOf(planes, 1), state.wood);
  EXPECT_EQ(At(planes, 0, 120), 1.0F);
}

TEST(Planes, VisibleItemsByKindAndNoHiddenOnes) {
  State state;
  state.SetItem(3, Item::kExtraBomb);
  state.SetItem(4, Item::kIncreaseRange);
  state.SetItem(5, Item::kKick);
  state.SetItem(6, Item::kKick);
  state.wood.Add(6);
  state.SetItem(7, Item::kExtraBomb);
  state.flames[1].Add(7);
  const Planes planes = Encode(state, 0);
  EXPECT_EQ(CellsOf(planes, 2), BitBoard::Of(3));
  EXPECT_EQ(CellsOf(planes, 3), BitBoard::Of(4));
  EXPECT_EQ(CellsOf(planes, 4), BitBoard::Of(5));
}

TEST(Planes, BombTimeAndReach) {
  const State state = WithBomb(60, /*life=*/3, /*strength=*/4, /*owner=*/2, Direction::kNone);
  const Planes planes = Encode(state, 0);
  EXPECT_FLOAT_EQ(At(planes, 5, 60), 1.0F - 3.0F / 9.0F);
  EXPECT_FLOAT_EQ(At(planes, 6, 60), 3.0F / 11.0F);
  EXPECT_EQ(CellsOf(planes, 7) | CellsOf(planes, 8), BitBoard());
}

TEST(Planes, FreshBombHasTimeZeroAndHugeReachIsCut) {
  const State state = WithBomb(60, /*life=*/9, /*strength=*/30, /*owner=*/0, Direction::kNone);
  const Planes planes = Encode(state, 0);
  EXPECT_EQ(At(planes, 5, 60), 0.0F);
  EXPECT_EQ(At(planes, 6, 60), 1.0F);
}

TEST(Planes, MotionHasASign) {
  const auto motion = [](Direction direction) {
    const Planes planes = Encode(WithBomb(17, 5, 2, 1, direction), 0);
    return std::array{At(planes, 7, 17), At(planes, 8, 17)};
  };
  EXPECT_EQ(motion(Direction::kLeft), (std::array{-1.0F, 0.0F}));
  EXPECT_EQ(motion(Direction::kRight), (std::array{1.0F, 0.0F}));
  EXPECT_EQ(motion(Direction::kUp), (std::array{0.0F, 1.0F}));
  EXPECT_EQ(motion(Direction::kDown), (std::array{0.0F, -1.0F}));
}

TEST(Planes, LongestFlameCounts) {
  State state;
  for (std::size_t life = 0; life < 3; ++life) state.flames[life].Add(static_cast<Cell>(life));
  state.flames[0].Add(2);
  const Planes planes = Encode(state, 0);
  EXPECT_FLOAT_EQ(At(planes, 9, 0), 1.0F / 3.0F);
  EXPECT_FLOAT_EQ(At(planes, 9, 1), 2.0F / 3.0F);
  EXPECT_FLOAT_EQ(At(planes, 9, 2), 1.0F);
}

TEST(Planes, AgentsInTheOrderOfTheViewer) {
  State state;
  for (std::size_t id = 0; id < kAgentCount; ++id) {
    state.agents[id] = {.cell = static_cast<std::uint8_t>(10 * id), .alive = id != 3};
  }
  const Planes planes = Encode(state, /*viewer=*/2);
  EXPECT_EQ(CellsOf(planes, 10), BitBoard::Of(20));
  EXPECT_EQ(CellsOf(planes, 11), BitBoard());  // agent 3 is dead
  EXPECT_EQ(CellsOf(planes, 12), BitBoard::Of(0));
  EXPECT_EQ(CellsOf(planes, 13), BitBoard::Of(10));
  EXPECT_EQ(ConstantOf(planes, 18), 1.0F);
  EXPECT_EQ(ConstantOf(planes, 19), 0.0F);
  EXPECT_EQ(ConstantOf(planes, 20), 1.0F);
  EXPECT_EQ(ConstantOf(planes, 21), 1.0F);
}

TEST(Planes, OwnStatisticsAndStep) {
  State state = WithBomb(60, 5, 2, /*owner=*/1, Direction::kNone);
  state.agents[1] = {.cell = 3, .ammo = 2, .blast_strength = 5, .alive = true, .can_kick = true};
  state.step = 400;
  const Planes own = Encode(state, 1);
  EXPECT_FLOAT_EQ(ConstantOf(own, 14), 4.0F / 11.0F);
  EXPECT_FLOAT_EQ(ConstantOf(own, 15), 1.0F / 5.0F);
  EXPECT_FLOAT_EQ(ConstantOf(own, 16), 3.0F / 5.0F);
  EXPECT_FLOAT_EQ(ConstantOf(own, 17), 1.0F);
  EXPECT_FLOAT_EQ(ConstantOf(own, 22), 400.0F / 799.0F);
  const Planes other = Encode(state, 0);
  EXPECT_EQ(ConstantOf(other, 15), 0.0F);
  EXPECT_EQ(ConstantOf(other, 17), 0.0F);
}

TEST(Planes, StepCountsAgainstTheStepLimit) {
  State state;
  state.step = 50;
  Planes planes;
  const GameSettings settings{.max_steps = 101};
  EncodePlanes(settings, {.state = &state, .viewer = 0}, planes);
  EXPECT_FLOAT_EQ(ConstantOf(planes, 22), 0.5F);
  state.step = 101;
  EncodePlanes(settings, {.state = &state, .viewer = 0}, planes);
  EXPECT_EQ(ConstantOf(planes, 22), 1.0F);
}

TEST(Planes, ValuesStayInRange) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const Planes planes = Encode(BusyState(Rng(seed)), static_cast<AgentId>(seed % 4));
    for (const float value : planes) ASSERT_TRUE(value >= -1.0F && value <= 1.0F) << seed;
  }
}

// A turned position has turned planes; the motion planes are two parts of a vector that turns too.
TEST(Planes, TurnWithThePosition) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const State state = BusyState(Rng(seed));
    const auto viewer = static_cast<AgentId>(seed % 4);
    const Planes planes = Encode(state, viewer);
    for (Symmetry symmetry = 0; symmetry < kSymmetryCount; ++symmetry) {
      const Planes turned = Encode(Transform(symmetry, state), viewer);
      for (Cell cell = 0; cell < kCellCount; ++cell) {
        const Cell to = Transform(symmetry, cell);
        for (int plane = 0; plane < kPlaneCount; ++plane) {
          if (plane == 7 || plane == 8) continue;
          ASSERT_EQ(At(turned, plane, to), At(planes, plane, cell)) << plane << " " << symmetry;
        }
        ASSERT_EQ(MotionAt(turned, to), Transform(symmetry, MotionAt(planes, cell))) << symmetry;
      }
    }
  }
}

TEST(Planes, FogIsZeroAndTheRestUnchanged) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const State state = BusyState(Rng(seed));
    BitBoard visible;
    Rng rng(seed);
    for (Cell cell = 0; cell < kCellCount; ++cell) {
      if (rng.Below(2) == 0) visible.Add(cell);
    }
    const Planes full = Encode(state, 0);
    const Planes fog = Encode(state, 0, visible);
    for (int plane = 0; plane < kPlaneCount; ++plane) {
      for (Cell cell = 0; cell < kCellCount; ++cell) {
        ASSERT_EQ(At(fog, plane, cell), visible.Has(cell) ? At(full, plane, cell) : 0.0F);
      }
    }
  }
}

// Bytes times scales are the planes: what a device computes from EncodePlaneCounts.
Planes Expanded(const GameSettings& settings, const Position& position) {
  std::array<std::int8_t, kPlaneCountsSize> counts;
  counts.fill(99);
  EncodePlaneCounts(position, counts);
  const auto scales = PlaneScales(settings);
  Planes planes{};
  for (int plane = 0; plane <= kPlaneCount; ++plane) {
    const int to = std::min(plane, kPlaneCount - 1);
    for (Cell cell = 0; cell < kCellCount; ++cell) {
      planes[static_cast<std::size_t>(to * kCellCount + cell)] +=
          scales[static_cast<std::size_t>(plane)] *
          static_cast<float>(counts[static_cast<std::size_t>(plane * kCellCount + cell)]);
    }
  }
  return planes;
}

TEST(Planes, CountsAreThePlanesInBytes) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    State state = BusyState(Rng(seed));
    state.step = static_cast<decltype(state.step)>(Rng(seed).Below(800));
    BitBoard visible = BitBoard::All();
    if (seed % 2 == 0) visible = state.rigid | state.wood;
    const Position position{
        .state = &state, .viewer = static_cast<AgentId>(seed % 4), .visible = visible};
    Planes planes;
    EncodePlanes({}, position, planes);
    const Planes expanded = Expanded({}, position);
    for (std::size_t i = 0; i < planes.size(); ++i) {
      ASSERT_NEAR(expanded[i], planes[i], 1e-6F) << seed << " plane " << i / kCellCount;
    }
  }
}

}  // namespace
}  // namespace powderkeg

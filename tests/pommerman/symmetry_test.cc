#include "common/pommerman/symmetry.h"

#include <gtest/gtest.h>

#include "common/pommerman/board_text.h"
#include "common/pommerman/step.h"
#include "tests/pommerman/random_game.h"

namespace powderkeg {
namespace {

Symmetry Inverse(Symmetry symmetry) { return symmetry < 4 ? (4 - symmetry) % 4 : symmetry; }

TEST(Symmetry, NumbersMirrorColumnsFirstAndThenTurnClockwise) {
  EXPECT_EQ(Transform(0, CellAt(0, 3)), CellAt(0, 3));
  EXPECT_EQ(Transform(1, CellAt(0, 3)), CellAt(3, 10));
  EXPECT_EQ(Transform(4, CellAt(0, 3)), CellAt(0, 7));
  EXPECT_EQ(Transform(5, CellAt(0, 3)), CellAt(7, 10));
  EXPECT_EQ(Transform(1, Direction::kUp), Direction::kRight);
  EXPECT_EQ(Transform(4, Direction::kLeft), Direction::kRight);
  EXPECT_EQ(Transform(4, Direction::kUp), Direction::kUp);
  EXPECT_EQ(Transform(3, Direction::kNone), Direction::kNone);
  EXPECT_EQ(Transform(2, Action::kUp), Action::kDown);
  EXPECT_EQ(Transform(2, Action::kBomb), Action::kBomb);
  EXPECT_EQ(Transform(2, Action::kStop), Action::kStop);
}

TEST(Symmetry, EachPermutesTheCellsAndItsInverseUndoesIt) {
  for (Symmetry symmetry = 0; symmetry < kSymmetryCount; ++symmetry) {
    BitBoard reached;
    for (Cell cell = 0; cell < kCellCount; ++cell) {
      reached.Add(Transform(symmetry, cell));
      EXPECT_EQ(Transform(Inverse(symmetry), Transform(symmetry, cell)), cell);
    }
    EXPECT_EQ(reached, BitBoard::All());
    for (const Direction direction : kDirections) {
      EXPECT_EQ(Transform(Inverse(symmetry), Transform(symmetry, direction)), direction);
    }
  }
}

TEST(Symmetry, TheEightDiffer) {
  for (Symmetry a = 0; a < kSymmetryCount; ++a) {
    for (Symmetry b = 0; b < a; ++b) {
      EXPECT_NE(std::pair(Transform(a, Cell{1}), Transform(a, Cell{2})),
                std::pair(Transform(b, Cell{1}), Transform(b, Cell{2})));
    }
  }
}

TEST(Symmetry, NeighboursStayNeighbours) {
  for (Symmetry symmetry = 0; symmetry < kSymmetryCount; ++symmetry) {
    for (Cell cell = 0; cell < kCellCount; ++cell) {
      for (const Direction direction : kDirections) {
        const Cell next = Neighbour(cell, direction);
        const Cell turned = Neighbour(Transform(symmetry, cell), Transform(symmetry, direction));
        EXPECT_EQ(turned, next == kNoCell ? kNoCell : Transform(symmetry, next));
      }
    }
  }
}

// Turning a position and playing turned actions is playing first and turning afterwards.
TEST(Symmetry, CommutesWithStepsOfRandomGames) {
  int step = 0;
  ForEachRandomStep(/*games_per_setting=*/40, [&](const GameSettings& settings, const State& before,
                                                  const JointAction& actions, const State& after) {
    const Symmetry symmetry = 1 + step++ % (kSymmetryCount - 1);
    JointAction turned_actions;
    for (AgentId id = 0; id < kAgentCount; ++id) {
      turned_actions[id] = Transform(symmetry, actions[id]);
    }
    State turned = Transform(symmetry, before);
    ASSERT_EQ(Transform(Inverse(symmetry), turned), before);
    Advance(settings, turned_actions, turned);
    ASSERT_EQ(turned, Transform(symmetry, after)) << ToText(before);
  });
  EXPECT_GT(step, 3000);
}

}  // namespace
}  // namespace powderkeg

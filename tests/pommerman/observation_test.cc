#include "common/pommerman/observation.h"

#include <gtest/gtest.h>

#include "tests/pommerman/position.h"

namespace powderkeg {
namespace {

const GameSettings kFullView;
const GameSettings kTeam = GameSettingsFor("PommeTeamCompetition-v0").value();
const GameSettings kRadio = GameSettingsFor("PommeRadio-v2").value();

TEST(Observation, ShowsTheWholeBoardInFreeForAll) {
  const State state = Position({"0#+o*brk..1"});
  const Observation seen = Observe(kFullView, state, 0);
  const std::array expected = {CellValue::kAgent0,        CellValue::kRigid,  CellValue::kWood,
                               CellValue::kBomb,          CellValue::kFlames, CellValue::kExtraBomb,
                               CellValue::kIncreaseRange, CellValue::kKick,   CellValue::kPassage,
                               CellValue::kPassage,       AgentValue(1)};
  for (Cell cell = 0; cell < kBoardSize; ++cell) EXPECT_EQ(seen.board[cell], expected[cell]);
}

TEST(Observation, ShowsBombsUnderAgentsButNotWhoseTheyAre) {
  const Observation seen = Observe(
      kFullView, Position({".1", ".."}, "bomb (0,1) owner 1 life 4 strength 6 moving down"), 0);
  EXPECT_EQ(seen.board[1], AgentValue(1));
  EXPECT_EQ(seen.bomb_life[1], 4);
  EXPECT_EQ(seen.bomb_blast_strength[1], 6);
  EXPECT_EQ(seen.bomb_moving_direction[1], Direction::kDown);
}

TEST(Observation, HidesItemsUnderWoodAndFlames) {
  const Observation seen =
      Observe(kFullView, Position({"+*"}, "hidden (0,0) k\nhidden (0,1) b"), 0);
  EXPECT_EQ(seen.board[0], CellValue::kWood);
  EXPECT_EQ(seen.board[1], CellValue::kFlames);
}

TEST(Observation, ShowsTheNewestFlameAsLifePlusOne) {
  const Observation seen = Observe(
      kFullView, Position({"**"}, "flame (0,0) life 0\nflame (0,1) life 0\nflame (0,1) life 2"), 0);
  EXPECT_EQ(seen.flame_life[0], 1);
  EXPECT_EQ(seen.flame_life[1], 3);
  EXPECT_EQ(seen.flame_life[2], 0);
}

TEST(Observation, FogStartsBeyondFourCells) {
  const State state = Position({"0...*+", ".....o", "", "", "....1", ".2"},
                               "flame (0,4) life 2\nbomb (1,5) life 3");
  const Observation seen = Observe(kTeam, state, 0);
  EXPECT_EQ(seen.board[4], CellValue::kFlames);
  EXPECT_EQ(seen.board[5], CellValue::kFog);
  EXPECT_EQ(seen.board[CellAt(1, 5)], CellValue::kFog);
  EXPECT_EQ(seen.bomb_life[CellAt(1, 5)], 0);
  EXPECT_EQ(seen.board[CellAt(4, 4)], AgentValue(1));
  EXPECT_EQ(seen.board[CellAt(5, 1)], CellValue::kFog);
  EXPECT_EQ(seen.alive, (std::array{true, true, true, false}));
}

TEST(Observation, TheDeadSeeFromWhereTheyDied) {
  const Observation seen = Observe(kTeam, Position({"0"}, "agent 1 dead (10,10) ammo 3"), 1);
  EXPECT_EQ(seen.position, CellAt(10, 10));
  EXPECT_EQ(seen.ammo, 3);
  EXPECT_EQ(seen.board[0], CellValue::kFog);
  EXPECT_EQ(seen.board[CellAt(6, 6)], CellValue::kPassage);
}

TEST(Observation, TellsOnesOwnStatistics) {
  const Observation seen =
      Observe(kFullView, Position({"0"}, "step 42\nagent 0 ammo 3 strength 5 kick"), 0);
  EXPECT_EQ(seen.self, 0);
  EXPECT_EQ(seen.ammo, 3);
  EXPECT_EQ(seen.blast_strength, 5);
  EXPECT_TRUE(seen.can_kick);
  EXPECT_EQ(seen.step, 42);
}

TEST(Observation, HearsTheTeamMateInRadioOnly) {
  const State state = Position({"0123"}, "agent 2 words 3 4\nagent 1 words 5 6");
  EXPECT_EQ(Observe(kRadio, state, 0).message, (Message{3, 4}));
  EXPECT_EQ(Observe(kRadio, state, 3).message, (Message{5, 6}));
  EXPECT_EQ(Observe(kTeam, state, 0).message, Message{});
}

TEST(VisibleCells, AreAWindowClippedToTheBoard) {
  EXPECT_EQ(VisibleCells(kFullView, 0), BitBoard::All());
  EXPECT_EQ(VisibleCells(kTeam, CellAt(5, 5)).Count(), 81);
  EXPECT_EQ(VisibleCells(kTeam, 0).Count(), 25);
  EXPECT_EQ(VisibleCells(kTeam, CellAt(10, 5)).Count(), 45);
}

}  // namespace
}  // namespace powderkeg

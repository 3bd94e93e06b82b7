// The phases of a step, in the order of the rules (section 3), and their odd corners (section 8).

#include "common/pommerman/step.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/pommerman/position.h"

namespace powderkeg {
namespace {

using enum Action;

// ---- 3.1 Flames age ----

TEST(Flames, BurnInThreeObservationsAndAreGoneBeforeAnybodyMoves) {
  State state = Position({"0.*"}, "flame (0,2) life 2");
  state = After(state, {kStop});
  EXPECT_EQ(state.ValueAt(2), CellValue::kFlames);
  state = After(state, {kRight});
  EXPECT_EQ(state.ValueAt(2), CellValue::kFlames);
  state = After(state, {kRight});
  EXPECT_EQ(state.ValueAt(2), CellValue::kAgent0);
}

TEST(Flames, UncoverAnItemThatCanBePickedUpAtOnce) {
  const State state = After(Position({"0*"}, "flame (0,1) life 0\nhidden (0,1) b"), {kRight});
  EXPECT_EQ(state.agents[0].ammo, 2);
  EXPECT_TRUE(state.Items().Empty());
}

TEST(Flames, ItemUnderASecondFlameIsLost) {
  State state = Position({"0.*"}, "flame (0,2) life 0\nflame (0,2) life 1\nhidden (0,2) r");
  state = After(state, {});
  EXPECT_TRUE(state.Items().Empty());
  EXPECT_EQ(state.ValueAt(2), CellValue::kFlames);
  state = After(state, {});
  EXPECT_EQ(state.ValueAt(2), CellValue::kPassage);
}

// ---- 3.2 What agents wish ----

TEST(Agents, MoveInTheFourDirections) {
  const State state = Position({"", ".0"});
  EXPECT_EQ(After(state, {kUp}).agents[0].cell, CellAt(0, 1));
  EXPECT_EQ(After(state, {kDown}).agents[0].cell, CellAt(2, 1));
  EXPECT_EQ(After(state, {kLeft}).agents[0].cell, CellAt(1, 0));
  EXPECT_EQ(After(state, {kRight}).agents[0].cell, CellAt(1, 2));
  EXPECT_EQ(After(state, {kStop}).agents[0].cell, CellAt(1, 1));
}

TEST(Agents, StayBeforeRigidWoodAndTheEdge) {
  const State state = Position({"0#", "+", "..........1"});
  EXPECT_EQ(After(state, {kRight}).agents[0].cell, 0);
  EXPECT_EQ(After(state, {kDown}).agents[0].cell, 0);
  EXPECT_EQ(After(state, {kUp}).agents[0].cell, 0);
  EXPECT_EQ(After(state, {kLeft}).agents[0].cell, 0);
  EXPECT_EQ(After(state, {kStop, kRight}).agents[1].cell, CellAt(2, 10));
}

TEST(Agents, LayABombOfTheirStrengthUnderThemselves) {
  const State state = After(Position({"", ".0"}, "agent 0 ammo 2 strength 5"), {kBomb});
  ASSERT_EQ(state.bomb_count, 1);
  EXPECT_EQ(state.bombs[0].cell, CellAt(1, 1));
  EXPECT_EQ(state.bombs[0].life, 9);
  EXPECT_EQ(state.bombs[0].blast_strength, 5);
  EXPECT_EQ(state.bombs[0].owner(), 0);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kNone);
  EXPECT_EQ(state.agents[0].ammo, 1);
  EXPECT_EQ(state.ValueAt(CellAt(1, 1)), CellValue::kAgent0);
}

TEST(Agents, LayNoBombWithoutAmmoNorOnABomb) {
  EXPECT_EQ(After(Position({"0"}, "agent 0 ammo 0"), {kBomb}).bomb_count, 0);
  const State state = After(Position({"0"}, "agent 0 ammo 3\nbomb (0,0) owner 1"), {kBomb});
  EXPECT_EQ(state.bomb_count, 1);
  EXPECT_EQ(state.agents[0].ammo, 3);
}

TEST(Agents, LayNoBombBeyondForty) {
  const std::string row(11, 'o');
  const State state = After(Position({"0", row, row, row, "ooooooo"}), {kBomb});
  EXPECT_EQ(state.bomb_count, kMaxBombs);
  EXPECT_EQ(state.agents[0].ammo, 1);
}

TEST(Agents, DeadOnesDoNothing) {
  const State state = Position({"1"}, "agent 0 dead (3,3)");
  const State bombed = After(state, {kBomb, kStop});
  EXPECT_EQ(bombed.bomb_count, 0);
  EXPECT_EQ(bombed.agents[0], state.agents[0]);
  EXPECT_EQ(After(state, {kRight}).agents[0], state.agents[0]);
}

TEST(Agents, BombsOfOneStepLieInAgentOrder) {
  const State state = After(Position({"3.2.1.0"}), {kBomb, kBomb, kBomb, kBomb});
  ASSERT_EQ(state.bomb_count, 4);
  for (AgentId id = 0; id < kAgentCount; ++id) EXPECT_EQ(state.bombs[id].owner(), id);
}

// ---- 3.3 What bombs wish ----

TEST(Bombs, RollOneCellAStep) {
  const State state = After(Position({".o"}, "bomb (0,1) moving right life 5"), {});
  EXPECT_EQ(state.bombs[0].cell, 2);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kRight);
  EXPECT_EQ(state.bomb_cells, BitBoard::Of(2));
}

TEST(Bombs, StopForGoodAtWallWoodItemAndEdge) {
  for (const std::string_view row : {"o#", "o+", "ob", "or", "ok"}) {
    const State state = After(Position({row}, "bomb (0,0) moving right"), {});
    EXPECT_EQ(state.bombs[0].cell, 0) << row;
    EXPECT_EQ(state.bombs[0].direction(), Direction::kNone) << row;
  }
  const State edge = After(Position({"o"}, "bomb (0,0) moving left"), {});
  EXPECT_EQ(edge.bombs[0].direction(), Direction::kNone);
}

TEST(Bombs, StoppedOnesDoNotResumeWhenTheObstacleLeaves) {
  State state = Position({"o0"}, "bomb (0,0) moving right");
  state = After(state, {kStop});
  EXPECT_EQ(state.bombs[0].direction(), Direction::kNone);
  state = After(state, {kDown});
  EXPECT_EQ(state.bombs[0].cell, 0);
  state = After(state, {kDown});
  EXPECT_EQ(state.bombs[0].cell, 0);
}

// ---- 3.4 Crossings ----

TEST(Crossings, SwappingAgentsBothStay) {
  const State state = After(Position({"01"}), {kRight, kLeft});
  EXPECT_EQ(state.agents[0].cell, 0);
  EXPECT_EQ(state.agents[1].cell, 1);
}

TEST(Crossings, SwappingBombsBothStop) {
  const State state =
      After(Position({"oo"}, "bomb (0,0) moving right\nbomb (0,1) moving left"), {});
  EXPECT_EQ(state.bombs[0].cell, 0);
  EXPECT_EQ(state.bombs[1].cell, 1);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kNone);
  EXPECT_EQ(state.bombs[1].direction(), Direction::kNone);
}

TEST(Crossings, AgentMeetingARollingBombHeadOnKicksItBack) {
  const State state = After(Position({"0o"}, "agent 0 kick\nbomb (0,1) moving left"), {kRight});
  EXPECT_EQ(state.agents[0].cell, 1);
  EXPECT_EQ(state.bombs[0].cell, 2);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kRight);
}

TEST(Crossings, AgentWithoutKickStaysBeforeARollingBombAndStopsIt) {
  const State state = After(Position({"0o"}, "bomb (0,1) moving left"), {kRight});
  EXPECT_EQ(state.agents[0].cell, 0);
  EXPECT_EQ(state.bombs[0].cell, 1);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kNone);
}

// ---- 3.5 Shared targets ----

TEST(SharedTargets, AllAgentsBounce) {
  const State state = After(Position({"0.1", ".2"}), {kRight, kLeft, kUp});
  EXPECT_EQ(state.agents[0].cell, 0);
  EXPECT_EQ(state.agents[1].cell, 2);
  EXPECT_EQ(state.agents[2].cell, CellAt(1, 1));
}

TEST(SharedTargets, AStandingAgentStopsAChain) {
  const State state = After(Position({"012"}), {kRight, kRight, kStop});
  EXPECT_EQ(state.agents[0].cell, 0);
  EXPECT_EQ(state.agents[1].cell, 1);
}

TEST(SharedTargets, ATrainOfAgentsMoves) {
  const State state = After(Position({"012"}), {kRight, kRight, kRight});
  EXPECT_EQ(state.agents[0].cell, 1);
  EXPECT_EQ(state.agents[1].cell, 2);
  EXPECT_EQ(state.agents[2].cell, 3);
}

TEST(SharedTargets, ARingOfAgentsTurns) {
  const State state = After(Position({"01", "32"}), {kRight, kDown, kLeft, kUp});
  EXPECT_EQ(state.agents[0].cell, CellAt(0, 1));
  EXPECT_EQ(state.agents[1].cell, CellAt(1, 1));
  EXPECT_EQ(state.agents[2].cell, CellAt(1, 0));
  EXPECT_EQ(state.agents[3].cell, CellAt(0, 0));
}

TEST(SharedTargets, TwoBombsForOneCellStop) {
  const State state =
      After(Position({"o.o"}, "bomb (0,0) moving right\nbomb (0,2) moving left"), {});
  EXPECT_EQ(state.bombs[0].cell, 0);
  EXPECT_EQ(state.bombs[1].cell, 2);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kNone);
}

TEST(SharedTargets, ABombStopsAtARestingBomb) {
  const State state = After(Position({"oo"}, "bomb (0,0) moving right\nbomb (0,1)"), {});
  EXPECT_EQ(state.bombs[0].cell, 0);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kNone);
}

TEST(SharedTargets, ATrainOfBombsRolls) {
  const State state =
      After(Position({"oo"}, "bomb (0,0) moving right\nbomb (0,1) moving right"), {});
  EXPECT_EQ(state.bombs[0].cell, 1);
  EXPECT_EQ(state.bombs[1].cell, 2);
  EXPECT_EQ(state.bomb_cells.Count(), 2);
}

TEST(SharedTargets, AKickerStaysBeforeABombThatAnotherBombIsAboutToHit) {
  const State state =
      After(Position({"0o.", ".o"}, "agent 0 kick\nbomb (0,1)\nbomb (1,1) moving up"), {kRight});
  EXPECT_EQ(state.agents[0].cell, 0);
  EXPECT_EQ(state.bombs[0].cell, 1);
  EXPECT_EQ(state.bombs[1].cell, CellAt(1, 1));
}

TEST(SharedTargets, ABombStopsBeforeACellThatTwoAgentsWant) {
  const State state = After(Position({"0.1", ".o"}, "bomb (1,1) moving up"), {kRight, kLeft});
  EXPECT_EQ(state.bombs[0].cell, CellAt(1, 1));
  EXPECT_EQ(state.bombs[0].direction(), Direction::kNone);
}

// ---- 3.6 Kicks and meetings ----

TEST(Kicks, SendABombAheadOfTheAgent) {
  const State state = After(Position({"0o"}, "agent 0 kick"), {kRight});
  EXPECT_EQ(state.agents[0].cell, 1);
  EXPECT_EQ(state.bombs[0].cell, 2);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kRight);
}

TEST(Kicks, NeedTheAbility) {
  const State state = After(Position({"0o"}), {kRight});
  EXPECT_EQ(state.agents[0].cell, 0);
  EXPECT_EQ(state.bombs[0].cell, 1);
}

TEST(Kicks, AreRefusedByWallWoodItemBombAgentAndEdge) {
  for (const std::string_view row : {"0o#", "0o+", "0ob", "0or", "0ok", "0oo", "0o1"}) {
    const State state = After(Position({row}, "agent 0 kick"), {kRight});
    EXPECT_EQ(state.agents[0].cell, 0) << row;
    EXPECT_EQ(state.bombs[0].cell, 1) << row;
    EXPECT_EQ(state.bombs[0].direction(), Direction::kNone) << row;
  }
  const State edge = After(Position({"o0"}, "agent 0 kick"), {kLeft});
  EXPECT_EQ(edge.agents[0].cell, 1);
}

TEST(Kicks, MayGoIntoFlames) {
  const State state = After(Position({"0o*"}, "agent 0 kick\nbomb (0,1) strength 1"), {kRight});
  EXPECT_EQ(state.bomb_count, 0);
  EXPECT_EQ(state.agents[0].cell, 1);
  EXPECT_TRUE(state.agents[0].alive);
}

TEST(Kicks, AreRefusedWhereAnybodyWishedToGoEvenIfItBounced) {
  // Agents 1 and 2 bounce off the cell behind the bomb.
  const State state = After(Position({"..1", "0o", "..2"}, "agent 0 kick"), {kRight, kDown, kUp});
  EXPECT_EQ(state.agents[0].cell, CellAt(1, 0));
  EXPECT_EQ(state.bombs[0].cell, CellAt(1, 1));
  EXPECT_EQ(state.agents[1].cell, CellAt(0, 2));
  EXPECT_EQ(state.agents[2].cell, CellAt(2, 2));
}

TEST(Kicks, MayAimAtACellThatAnAgentLeaves) {
  const State state = After(Position({"0o1"}, "agent 0 kick"), {kRight, kDown});
  EXPECT_EQ(state.agents[0].cell, 1);
  EXPECT_EQ(state.bombs[0].cell, 2);
  EXPECT_EQ(state.agents[1].cell, CellAt(1, 2));
}

TEST(Kicks, OfAFreshBombWhileItsLayerLeaves) {
  State state = After(Position({"10"}, "agent 1 kick"), {kBomb});
  state = After(state, {kDown, kRight});
  EXPECT_EQ(state.agents[0].cell, CellAt(1, 1));
  EXPECT_EQ(state.agents[1].cell, 1);
  EXPECT_EQ(state.bombs[0].cell, 2);
}

TEST(Kicks, TwoAgentsForOneBombBothBounce) {
  const State state = After(Position({"0o1"}, "agent 0 kick\nagent 1 kick"), {kRight, kLeft});
  EXPECT_EQ(state.agents[0].cell, 0);
  EXPECT_EQ(state.agents[1].cell, 2);
  EXPECT_EQ(state.bombs[0].cell, 1);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kNone);
}

TEST(Kicks, DeflectARollingBombDiagonally) {
  const State state =
      After(Position({".o", "0", ""}, "agent 0 kick\nbomb (0,1) moving down"), {kRight});
  EXPECT_EQ(state.agents[0].cell, CellAt(1, 1));
  EXPECT_EQ(state.bombs[0].cell, CellAt(1, 2));
  EXPECT_EQ(state.bombs[0].direction(), Direction::kRight);
}

TEST(Kicks, BoomerangKeepsItsPlaceAndTurnsRound) {
  // The bomb rolls left towards the cell that the agent enters from the left: it is sent back.
  const State state = After(Position({"0.o"}, "agent 0 kick\nbomb (0,2) moving left"), {kRight});
  EXPECT_EQ(state.agents[0].cell, 1);
  EXPECT_EQ(state.bombs[0].cell, 2);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kRight);
}

TEST(Meetings, AnAgentWithoutKickAndARollingBombForOneCellBothStay) {
  const State state = After(Position({"0.o"}, "bomb (0,2) moving left"), {kRight});
  EXPECT_EQ(state.agents[0].cell, 0);
  EXPECT_EQ(state.bombs[0].cell, 2);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kNone);
}

TEST(Meetings, ABombStopsAtAStandingAgent) {
  const State state = After(Position({"o0"}, "bomb (0,0) moving right"), {kStop});
  EXPECT_EQ(state.bombs[0].cell, 0);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kNone);
}

TEST(Meetings, ABombRollsIntoTheCellAnAgentLeaves) {
  const State state = After(Position({"o0"}, "bomb (0,0) moving right"), {kDown});
  EXPECT_EQ(state.bombs[0].cell, 1);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kRight);
}

TEST(Meetings, ABombStopsWhenTheAgentBeforeItBounces) {
  const State state = After(Position({"o0", "", ".1"}, "bomb (0,0) moving right"), {kDown, kUp});
  EXPECT_EQ(state.agents[0].cell, 1);
  EXPECT_EQ(state.bombs[0].cell, 0);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kNone);
}

TEST(Meetings, AnAgentLeavesItsRestingBombAndStaysOnIt) {
  const State state = Position({".0"}, "bomb (0,1)");
  EXPECT_EQ(After(state, {kLeft}).agents[0].cell, 0);
  const State stayed = After(state, {kStop});
  EXPECT_EQ(stayed.agents[0].cell, 1);
  EXPECT_EQ(stayed.bombs[0].cell, 1);
}

// ---- 3.7 Late reverts ----

TEST(LateReverts, TwoKicksToOneCellAreBothUndone) {
  const State state = After(Position({"0o.o1"}, "agent 0 kick\nagent 1 kick"), {kRight, kLeft});
  EXPECT_EQ(state.agents[0].cell, 0);
  EXPECT_EQ(state.agents[1].cell, 4);
  EXPECT_EQ(state.bombs[0].cell, 1);
  EXPECT_EQ(state.bombs[1].cell, 3);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kNone);
  EXPECT_EQ(state.bombs[1].direction(), Direction::kNone);
}

TEST(LateReverts, AnAgentFollowingABombThatIsStoppedGoesBack) {
  // The bomb hits standing agent 1; agent 0 wanted its place.
  const State state =
      After(Position({"0o1"}, "agent 0 kick\nbomb (0,1) moving right"), {kRight, kStop});
  EXPECT_EQ(state.agents[0].cell, 0);
  EXPECT_EQ(state.bombs[0].cell, 1);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kNone);
}

TEST(LateReverts, AKickIsUndoneWhereItsTargetIsNotLeftAfterAll) {
  // Agent 1 wants to leave the cell behind the bomb but cannot enter the second bomb's cell.
  const State state = After(Position({"0o1", "..o"}, "agent 0 kick"), {kRight, kDown});
  EXPECT_EQ(state.agents[0].cell, 0);
  EXPECT_EQ(state.agents[1].cell, 2);
  EXPECT_EQ(state.bombs[0].cell, 1);
  EXPECT_EQ(state.bombs[0].direction(), Direction::kNone);
}

TEST(LateReverts, ABoomerangWhoseCellAnotherKickAimsAtIsUndone) {
  // Agent 0 would send the bomb at (0,2) back to its cell, agent 1 kicks its bomb there.
  const State state =
      After(Position({"0.o", "..o", "..1"},
                     "agent 0 kick\nagent 1 kick\nbomb (0,2) moving left\nbomb (1,2)"),
            {kRight, kUp});
  EXPECT_EQ(state.agents[0].cell, 0);
  EXPECT_EQ(state.agents[1].cell, CellAt(2, 2));
  EXPECT_EQ(state.bombs[0].cell, 2);
  EXPECT_EQ(state.bombs[1].cell, CellAt(1, 2));
  EXPECT_EQ(state.bombs[0].direction(), Direction::kNone);
}

// ---- 3.8 Picking up ----

TEST(PickUp, GivesAmmoStrengthAndKick) {
  EXPECT_EQ(After(Position({"0b"}), {kRight}).agents[0].ammo, 2);
  EXPECT_EQ(After(Position({"0r"}), {kRight}).agents[0].blast_strength, 3);
  const State state = After(Position({"0k"}), {kRight});
  EXPECT_TRUE(state.agents[0].can_kick);
  EXPECT_TRUE(state.Items().Empty());
}

TEST(PickUp, StopsAtTheCaps) {
  EXPECT_EQ(After(Position({"0b"}, "agent 0 ammo 10"), {kRight}).agents[0].ammo, 10);
  EXPECT_EQ(After(Position({"0r"}, "agent 0 strength 10"), {kRight}).agents[0].blast_strength, 10);
}

TEST(PickUp, AStrengthAboveTheTeamCapIsLost) {
  const GameSettings team = GameSettingsFor("PommeTeamCompetition-v0").value();
  EXPECT_EQ(After(Position({"0r"}, "agent 0 strength 4"), {kRight}, team).agents[0].blast_strength,
            4);
  EXPECT_EQ(After(Position({"0r"}, "agent 0 strength 7"), {kRight}, team).agents[0].blast_strength,
            4);
}

TEST(PickUp, HappensEvenInTheStepOfDeath) {
  const State state =
      After(Position({"0b", ".o"}, "agent 0 strength 2\nbomb (1,1) life 1"), {kRight});
  EXPECT_FALSE(state.agents[0].alive);
  EXPECT_EQ(state.agents[0].cell, 1);
  EXPECT_EQ(state.agents[0].ammo, 3);  // the item and the exploded bomb
  EXPECT_TRUE(state.Items().Empty());
}

// ---- 3.9 Ticking ----

TEST(Ticking, AKickedBombOfLifeOneMovesAndThenExplodes) {
  const State state =
      After(Position({"0o"}, "agent 0 kick\nbomb (0,1) life 1 strength 1"), {kRight});
  EXPECT_EQ(state.flames[2], BitBoard::Of(2));
  EXPECT_TRUE(state.agents[0].alive);
}

TEST(Ticking, ABombRollingIntoFlamesExplodesAtOnce) {
  const State state =
      After(Position({"o*"}, "bomb (0,0) moving right life 8 strength 1\nflame (0,1) life 1"), {});
  EXPECT_EQ(state.bomb_count, 0);
  EXPECT_EQ(state.flames[2], BitBoard::Of(1));
}

TEST(Ticking, ABombRollingIntoDyingFlamesDoesNot) {
  const State state =
      After(Position({"o*"}, "bomb (0,0) moving right life 8\nflame (0,1) life 0"), {});
  EXPECT_EQ(state.bomb_count, 1);
}

TEST(Ticking, ABombOfNoLifeNeverExplodesByItself) {
  const State state = After(Position({"o"}, "bomb (0,0) life 0"), {});
  EXPECT_EQ(state.bomb_count, 1);
  EXPECT_EQ(state.bombs[0].life, -1);
}

// ---- 3.10 Explosions ----

TEST(Explosions, BurnStrengthMinusOneCellsEachWay) {
  const State state = After(Position({"", "", "", "...o"}, "bomb (3,3) life 1 strength 3"), {});
  EXPECT_EQ(state.flames[2].Count(), 9);
  EXPECT_TRUE(state.flames[2].Has(CellAt(1, 3)));
  EXPECT_FALSE(state.flames[2].Has(CellAt(0, 3)));
  EXPECT_TRUE(state.flames[2].Has(CellAt(3, 5)));
  EXPECT_FALSE(state.flames[2].Has(CellAt(3, 6)));
}

TEST(Explosions, OfStrengthOneBurnTheirOwnCell) {
  const State state = After(Position({"o"}, "bomb (0,0) life 1 strength 1"), {});
  EXPECT_EQ(state.flames[2], BitBoard::Of(0));
}

TEST(Explosions, EndBeforeRigidOnWoodAndAtTheEdge) {
  const State state = After(Position({".o.#", ".+", ".+"}, "bomb (0,1) life 1 strength 10"), {});
  BitBoard expected;
  for (const Cell cell : {0, 1, 2, CellAt(1, 1)}) expected.Add(cell);
  EXPECT_EQ(state.flames[2], expected);
  EXPECT_EQ(state.wood, BitBoard::Of(CellAt(2, 1)));
}

TEST(Explosions, PassOverAgentsBombsItemsAndFlames) {
  const State state =
      After(Position({"o0ob*.."}, "bomb (0,0) life 1 strength 7\nbomb (0,2) strength 1"), {});
  EXPECT_EQ(state.flames[2].Count(), 7 + 6);
  EXPECT_TRUE(state.flames[2].Has(6));
}

TEST(Explosions, ChainInOneStepBehindTheSameWood) {
  // The wood between shields what is behind it although both bombs reach it.
  const State state = After(
      Position({"o.o+o"}, "bomb (0,0) life 1 strength 3\nbomb (0,2) life 9 strength 9\nbomb (0,4)"),
      {});
  EXPECT_EQ(state.bomb_count, 1);
  EXPECT_EQ(state.bombs[0].cell, 4);
  EXPECT_TRUE(state.wood.Empty());
  EXPECT_TRUE(state.flames[2].Has(3));
  EXPECT_FALSE(state.flames[2].Has(4));
}

TEST(Explosions, RemainingBombsKeepTheirOrder) {
  const State state = After(Position({"o", "", "..o", "", "....o"},
                                     "bomb (2,2) owner 1\nbomb (0,0) life 1\nbomb (4,4) owner 2"),
                            {});
  ASSERT_EQ(state.bomb_count, 2);
  EXPECT_EQ(state.bombs[0].owner(), 1);
  EXPECT_EQ(state.bombs[1].owner(), 2);
  EXPECT_EQ(state.bombs[2], Bomb{});
  EXPECT_EQ(state.bomb_cells.Count(), 2);
}

TEST(Explosions, ReturnAmmoEvenToTheDeadUpToTen) {
  State state = After(Position({"o"}, "agent 0 dead (5,5) ammo 3\nbomb (0,0) life 1"), {});
  EXPECT_EQ(state.agents[0].ammo, 4);
  state = After(Position({"o"}, "agent 0 dead (5,5) ammo 10\nbomb (0,0) life 1"), {});
  EXPECT_EQ(state.agents[0].ammo, 10);
}

TEST(Explosions, HaveTheStrengthOfTheirLaying) {
  State state = After(Position({"0r"}, "agent 0 strength 2"), {kBomb});
  state = After(state, {kRight});
  EXPECT_EQ(state.agents[0].blast_strength, 3);
  EXPECT_EQ(state.bombs[0].blast_strength, 2);
}

// ---- 3.11 Redrawing ----

TEST(Burning, DestroysVisibleItemsAndUncoversHiddenOnesLater) {
  State state = Position({"bo+"}, "bomb (0,1) life 1\nhidden (0,2) k");
  state = After(state, {});
  EXPECT_EQ(state.ItemAt(0), Item::kNone);
  EXPECT_EQ(state.HiddenItems(), BitBoard::Of(2));
  EXPECT_EQ(state.ValueAt(2), CellValue::kFlames);
  for (int i = 0; i < 3; ++i) state = After(state, {});
  EXPECT_EQ(state.ValueAt(2), CellValue::kKick);
}

TEST(Burning, KillsWhoeverStandsInNewOrOldFlamesAtOnce) {
  const State state = After(Position({"0o1", "*2"}, "bomb (0,1) life 1\nflame (1,0) life 2"),
                            {kStop, kStop, kLeft});
  EXPECT_EQ(state.AgentCells().Count(), 0);
  EXPECT_EQ(state.agents[2].cell, CellAt(1, 0));
}

TEST(Burning, PutsANewFlameOverAnOldOne) {
  const State state = After(Position({"o*"}, "bomb (0,0) life 1\nflame (0,1) life 2"), {});
  EXPECT_TRUE(state.flames[1].Has(1));
  EXPECT_TRUE(state.flames[2].Has(1));
}

// ---- 3.12 and messages ----

TEST(Stepping, CountsAndClearsTheWordsOfTheStepBefore) {
  State state = Position({"0.1"}, "step 7\nagent 0 words 3 4");
  Step(GameSettings{}, JointAction{}, state);
  EXPECT_EQ(state.step, 8);
  EXPECT_EQ(state.messages[0], Message{});
}

TEST(Stepping, KeepsTheWordsOfThoseAliveBeforeTheStep) {
  State state = Position({"0o"}, "agent 2 dead (5,5)\nbomb (0,1) life 1");
  Step(GameSettings{}, JointAction{}, {{{1, 2}, {}, {5, 6}, {}}}, state);
  EXPECT_FALSE(state.agents[0].alive);
  EXPECT_EQ(state.messages[0], (Message{1, 2}));
  EXPECT_EQ(state.messages[2], Message{});
}

TEST(Stepping, AFinishedGameGoesOn) {
  State state = Position({"0"}, "step 800");
  Step(GameSettings{}, Actions({kRight}), state);
  EXPECT_EQ(state.step, 801);
  EXPECT_EQ(state.agents[0].cell, 1);
}

}  // namespace
}  // namespace powderkeg

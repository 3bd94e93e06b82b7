// Ends, rewards, collapses and legal actions (rules, sections 4 and 5).

#include <gtest/gtest.h>

#include "common/pommerman/step.h"
#include "tests/pommerman/position.h"

namespace powderkeg {
namespace {

using enum Action;
using Rewards = std::array<std::int8_t, kAgentCount>;

const GameSettings kFreeForAll;
const GameSettings kTeam = GameSettingsFor("PommeTeamCompetition-v0").value();
const GameSettings kOneVsOne = GameSettingsFor("OneVsOne-v0").value();
const GameSettings kCollapsing = GameSettingsFor("PommeFFA-v1").value();

// A position in which these agents live.
State Living(std::string_view agents, int step = 10) {
  State state = Position({agents});
  state.step = static_cast<std::uint16_t>(step);
  return state;
}

// ---- Ends and rewards ----

TEST(FreeForAll, GoesOnWhileTwoLive) {
  EXPECT_EQ(OutcomeOf(kFreeForAll, Living("0123")), Outcome{});
  const Outcome outcome = OutcomeOf(kFreeForAll, Living("13"));
  EXPECT_FALSE(outcome.done);
  EXPECT_EQ(outcome.result, Result::kIncomplete);
  EXPECT_EQ(outcome.rewards, (Rewards{-1, 0, -1, 0}));
}

TEST(FreeForAll, TheLastOneWinsEvenOnTheLastStep) {
  for (const int step : {10, 800}) {
    const Outcome outcome = OutcomeOf(kFreeForAll, Living("2", step));
    EXPECT_TRUE(outcome.done);
    EXPECT_EQ(outcome.result, Result::kWin);
    EXPECT_EQ(outcome.winners, 0b0100);
    EXPECT_EQ(outcome.rewards, (Rewards{-1, -1, 1, -1}));
  }
}

TEST(FreeForAll, DyingTogetherAndTimeAreTies) {
  for (const State& state : {Living(""), Living("0123", 800), Living("02", 800)}) {
    const Outcome outcome = OutcomeOf(kFreeForAll, state);
    EXPECT_TRUE(outcome.done);
    EXPECT_EQ(outcome.result, Result::kTie);
    EXPECT_EQ(outcome.winners, 0);
    EXPECT_EQ(outcome.rewards, (Rewards{-1, -1, -1, -1}));
  }
}

TEST(Team, GoesOnWithoutRewardsWhileBothTeamsLive) {
  EXPECT_EQ(OutcomeOf(kTeam, Living("0123")), Outcome{});
  EXPECT_EQ(OutcomeOf(kTeam, Living("03")), Outcome{});
}

TEST(Team, TheOnlyTeamWinsWithItsDead) {
  const Outcome even = OutcomeOf(kTeam, Living("2"));
  EXPECT_EQ(even.result, Result::kWin);
  EXPECT_EQ(even.winners, 0b0101);
  EXPECT_EQ(even.rewards, (Rewards{1, -1, 1, -1}));
  const Outcome odd = OutcomeOf(kTeam, Living("13", 800));
  EXPECT_EQ(odd.winners, 0b1010);
  EXPECT_EQ(odd.rewards, (Rewards{-1, 1, -1, 1}));
  EXPECT_TRUE(odd.done);
}

TEST(Team, DyingTogetherAndTimeAreTies) {
  for (const State& state : {Living(""), Living("03", 800)}) {
    const Outcome outcome = OutcomeOf(kTeam, state);
    EXPECT_TRUE(outcome.done);
    EXPECT_EQ(outcome.result, Result::kTie);
    EXPECT_EQ(outcome.rewards, (Rewards{-1, -1, -1, -1}));
  }
}

TEST(OneVsOne, CountsTwoSeatsOnly) {
  EXPECT_EQ(OutcomeOf(kOneVsOne, Living("01")), Outcome{});
  EXPECT_EQ(OutcomeOf(kOneVsOne, Living("1")).rewards, (Rewards{-1, 1, 0, 0}));
  EXPECT_EQ(OutcomeOf(kOneVsOne, Living("01", 800)).rewards, (Rewards{-1, -1, 0, 0}));
  const Outcome both_dead = OutcomeOf(kOneVsOne, Living(""));
  EXPECT_TRUE(both_dead.done);
  EXPECT_EQ(both_dead.result, Result::kTie);
  EXPECT_EQ(both_dead.rewards, Rewards{});
}

// ---- Collapse ----

TEST(Collapsing, TurnsOneRingIntoWallsWithAllThatIsOnIt) {
  State state = Position({"0b+*o......", "1"},
                         "step 500\nhidden (0,2) r\nbomb (0,4) owner 2 life 3\n"
                         "agent 2 dead (5,5) ammo 1");
  Collapse(kCollapsing, state);
  EXPECT_EQ(state.rigid.Count(), 40);
  EXPECT_TRUE(state.wood.Empty());
  EXPECT_TRUE(state.Items().Empty());
  EXPECT_TRUE(state.Flames().Empty());
  EXPECT_EQ(state.bomb_count, 0);
  EXPECT_TRUE(state.bomb_cells.Empty());
  EXPECT_EQ(state.agents[2].ammo, 2);
  EXPECT_EQ(state.AgentCells().Count(), 0);
}

TEST(Collapsing, GoesInwardsAtItsSteps) {
  const State inner = Position({"", "", "", "", "", ".....0"});
  State state = inner;
  for (int step = 0; step <= 800; ++step) {
    state.step = static_cast<std::uint16_t>(step);
    Collapse(kCollapsing, state);
    const int expected = step < 500 ? 0 : step < 575 ? 40 : step < 650 ? 72 : step < 725 ? 96 : 112;
    ASSERT_EQ(state.rigid.Count(), expected) << step;
  }
  EXPECT_TRUE(state.agents[0].alive);
}

TEST(Collapsing, NeverHappensWithoutSteps) {
  State state = Position({"0"}, "step 500");
  const State before = state;
  Collapse(kFreeForAll, state);
  EXPECT_EQ(state, before);
}

TEST(Collapsing, EndsTheGameOnlyWithTheNextStep) {
  State state = Position({"0", "", "..1"}, "step 499");
  EXPECT_FALSE(Advance(kCollapsing, Actions({}), state).done);
  EXPECT_EQ(state.AgentCells().Count(), 1);
  const Outcome outcome = Advance(kCollapsing, Actions({}), state);
  EXPECT_TRUE(outcome.done);
  EXPECT_EQ(outcome.winners, 0b0010);
}

// ---- Legal actions ----

ActionSet Set(std::initializer_list<Action> actions) {
  int set = 0;
  for (const Action action : actions) set |= 1 << static_cast<int>(action);
  return static_cast<ActionSet>(set);
}

TEST(LegalActions, AreAllInTheOpen) {
  EXPECT_EQ(LegalActions(Position({"", ".0"}), 0), Set({kStop, kUp, kDown, kLeft, kRight, kBomb}));
}

TEST(LegalActions, EndAtEdgesWallsWoodAndAgents) {
  EXPECT_EQ(LegalActions(Position({"0#", "+"}), 0), Set({kStop, kBomb}));
  EXPECT_EQ(LegalActions(Position({"01", "2"}), 0), Set({kStop, kBomb}));
}

TEST(LegalActions, ItemsAreOpen) {
  EXPECT_EQ(LegalActions(Position({"0b", "k"}), 0), Set({kStop, kRight, kDown, kBomb}));
}

TEST(LegalActions, ABombNeedsAmmoAndAFreeCell) {
  EXPECT_EQ(LegalActions(Position({"0#", "#"}, "agent 0 ammo 0"), 0), Set({kStop}));
  EXPECT_EQ(LegalActions(Position({"0#", "#"}, "bomb (0,0)"), 0), Set({kStop}));
}

TEST(LegalActions, BombsAreOpenToKickersUnlessSomebodyStandsOnThem) {
  EXPECT_EQ(LegalActions(Position({"0o", "#"}), 0), Set({kStop, kBomb}));
  EXPECT_EQ(LegalActions(Position({"0o", "#"}, "agent 0 kick"), 0), Set({kStop, kRight, kBomb}));
  EXPECT_EQ(LegalActions(Position({"01", "#"}, "agent 0 kick\nbomb (0,1)"), 0),
            Set({kStop, kBomb}));
}

TEST(LegalActions, FlamesAreOpenOnceTheyAreGoneInTheNextStep) {
  EXPECT_EQ(LegalActions(Position({"0*", "*"}, "flame (0,1) life 0\nflame (1,0) life 1"), 0),
            Set({kStop, kRight, kBomb}));
  EXPECT_EQ(LegalActions(Position({"0*", "#"}, "flame (0,1) life 0\nflame (0,1) life 2"), 0),
            Set({kStop, kBomb}));
}

TEST(LegalActions, TheDeadBlockNothing) {
  EXPECT_EQ(LegalActions(Position({"0.", "#"}, "agent 1 dead (0,1)"), 0),
            Set({kStop, kRight, kBomb}));
}

}  // namespace
}  // namespace powderkeg

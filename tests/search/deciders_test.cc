#include "actors/search/deciders.h"

#include <gtest/gtest.h>

#include "tests/pommerman/board_reader.h"

namespace powderkeg {
namespace {

constexpr std::string_view kBoard = R"(
    0..........
    ...........
    ...1.......
    ...........
    ...........
    ...........
    3..........
    ...........
    ...........
    ...........
    ..........2
)";

SearchSettings TwoPlayer() {
  SearchSettings settings;
  settings.tree = TreeKind::kTwoPlayer;
  return settings;
}

TEST(Deciders, OneTreePlayerDecidesAlone) {
  EXPECT_EQ(DeciderAfter({}, {}, FromText(kBoard), 0), 0);
}

TEST(Deciders, ClosestEnemyFollows) {
  EXPECT_EQ(DeciderAfter(TwoPlayer(), {}, FromText(kBoard), 0), 1);
  EXPECT_EQ(DeciderAfter(TwoPlayer(), {}, FromText(kBoard), 3), 0);
}

TEST(Deciders, DeadAgentsDoNotMove) {
  State state = FromText(kBoard);
  state.agents[1].alive = false;
  EXPECT_EQ(DeciderAfter(TwoPlayer(), {}, state, 0), 3);
}

TEST(Deciders, EqualDistancesGoToTheLowestId) {
  State state = FromText(kBoard);
  state.agents[3].cell = static_cast<std::uint8_t>(CellAt(5, 0));
  EXPECT_EQ(DeciderAfter(TwoPlayer(), {}, state, 0), 1);
}

TEST(Deciders, TeamMatesAreNoEnemies) {
  GameSettings team;
  team.mode = Mode::kTeam;
  EXPECT_EQ(DeciderAfter(TwoPlayer(), team, FromText(kBoard), 1), 0);
  State state = FromText(kBoard);
  state.agents[0].alive = false;
  EXPECT_EQ(DeciderAfter(TwoPlayer(), team, state, 1), 2);
}

TEST(Deciders, NobodyInReachMakesTheStepOnePlayer) {
  SearchSettings settings = TwoPlayer();
  settings.simulated_opponent_reach = 4;
  EXPECT_EQ(DeciderAfter(settings, {}, FromText(kBoard), 0), 0);
}

TEST(Deciders, DangerComesBeforeDistance) {
  SearchSettings settings = TwoPlayer();
  settings.simulated_opponent = SimulatedOpponent::kMostDangerous;
  State state = FromText(kBoard);
  EXPECT_EQ(DeciderAfter(settings, {}, state, 0), 1) << "nobody's bomb reaches that far";
  state.agents[3].blast_strength = 7;
  EXPECT_EQ(DeciderAfter(settings, {}, state, 0), 3);
  state.wood.Add(CellAt(3, 0));
  EXPECT_EQ(DeciderAfter(settings, {}, state, 0), 1) << "wood shields";
  state.wood.Remove(CellAt(3, 0));
  state.agents[3].ammo = 0;
  EXPECT_EQ(DeciderAfter(settings, {}, state, 0), 1);
}

}  // namespace
}  // namespace powderkeg

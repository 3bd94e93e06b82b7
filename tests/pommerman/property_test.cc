// What holds in every step of every game.

#include <gtest/gtest.h>

#include <algorithm>

#include "common/pommerman/generate.h"
#include "common/pommerman/observation.h"
#include "common/pommerman/step.h"
#include "tests/pommerman/board_reader.h"
#include "tests/pommerman/random_game.h"

namespace powderkeg {
namespace {

constexpr int kGamesPerSetting = 40;

void ExpectBombsConsistent(const State& state) {
  BitBoard cells;
  for (const Bomb& bomb : state.Bombs()) {
    ASSERT_FALSE(cells.Has(bomb.cell)) << "two bombs on one cell";
    cells.Add(bomb.cell);
  }
  ASSERT_EQ(cells, state.bomb_cells);
  for (int index = state.bomb_count; index < kMaxBombs; ++index) {
    ASSERT_EQ(state.bombs[index], Bomb{}) << "an unused bomb is not a default value";
  }
}

void ExpectAgentsApart(const State& state) {
  ASSERT_EQ(state.AgentCells().Count(), std::ranges::count(state.agents, true, &AgentState::alive));
  ASSERT_TRUE((state.AgentCells() & (state.rigid | state.wood | state.VisibleItems())).Empty());
}

void ExpectLayersConsistent(const State& state) {
  ASSERT_TRUE((state.rigid & state.wood).Empty());
  ASSERT_TRUE((state.rigid & (state.Items() | state.Flames())).Empty());
  ASSERT_TRUE((state.wood & state.Flames()).Empty());
  ASSERT_TRUE((state.VisibleItems() & (state.bomb_cells | state.rigid)).Empty());
  ASSERT_TRUE((state.bomb_cells & (state.rigid | state.wood)).Empty());
  ASSERT_TRUE((state.Flames() & (state.bomb_cells | state.AgentCells())).Empty());
}

TEST(EveryStep, KeepsTheInvariantsOfStates) {
  ForEachRandomStep(kGamesPerSetting, [](const GameSettings&, const State& before,
                                         const JointAction&, const State& after) {
    SCOPED_TRACE(ToText(before));
    ExpectBombsConsistent(after);
    ExpectAgentsApart(after);
    ExpectLayersConsistent(after);
  });
}

TEST(EveryStep, NeverRevivesNorMovesFar) {
  ForEachRandomStep(kGamesPerSetting, [](const GameSettings&, const State& before,
                                         const JointAction& actions, const State& after) {
    ASSERT_EQ(after.step, before.step + 1);
    for (AgentId id = 0; id < kAgentCount; ++id) {
      const AgentState& from = before.agents[id];
      const AgentState& to = after.agents[id];
      ASSERT_TRUE(from.alive || !to.alive);
      ASSERT_TRUE(to.cell == from.cell ||
                  (from.alive && to.cell == TargetOf(from.cell, actions[id])));
    }
  });
}

TEST(EveryStep, IsAFunctionOfItsArguments) {
  ForEachRandomStep(kGamesPerSetting, [](const GameSettings& settings, const State& before,
                                         const JointAction& actions, const State& after) {
    const State copy = before;
    ASSERT_EQ(copy, before);
    State again = copy;
    Advance(settings, actions, again);
    ASSERT_EQ(again, after);
  });
}

TEST(EveryStep, IgnoresWhatTheDeadWant) {
  ForEachRandomStep(kGamesPerSetting, [](const GameSettings& settings, const State& before,
                                         JointAction actions, const State& after) {
    for (AgentId id = 0; id < kAgentCount; ++id) {
      if (!before.agents[id].alive) actions[id] = Action::kBomb;
    }
    State again = before;
    Advance(settings, actions, again);
    ASSERT_EQ(again, after);
  });
}

TEST(EveryStep, SurvivesAsText) {
  ForEachRandomStep(kGamesPerSetting,
                    [](const GameSettings&, const State&, const JointAction&, const State& after) {
                      const std::string text = ToText(after);
                      ASSERT_EQ(FromText(text), after) << text;
                      ASSERT_EQ(ToText(FromText(text)), text);
                    });
}

// Legal moves are moves that can succeed: a free agent that takes one alone gets there, or kicks in
// vain.
TEST(EveryStep, LegalMovesLeadWhereTheyPoint) {
  ForEachRandomStep(kGamesPerSetting, [](const GameSettings& settings, const State& before,
                                         const JointAction&, const State&) {
    for (AgentId id = 0; id < kAgentCount; ++id) {
      if (!before.agents[id].alive) continue;
      const ActionSet legal = LegalActions(before, id);
      for (const Direction direction : kDirections) {
        const Cell target = NeighbourOrSelf(before.agents[id].cell, direction);
        const bool free = !before.bomb_cells.Has(target) && !before.bomb_cells.Any();
        if ((legal >> static_cast<int>(direction) & 1) == 0 || !free) continue;
        State moved = before;
        JointAction actions{};
        actions[id] = ActionOf(direction);
        Step(settings, actions, moved);
        ASSERT_EQ(moved.agents[id].cell, target) << ToText(before);
        ASSERT_TRUE(moved.agents[id].alive) << ToText(before);
      }
    }
  });
}

TEST(EveryStep, FullViewShowsTheBoardOfTheState) {
  const GameSettings full_view;
  ForEachRandomStep(/*games_per_setting=*/4,
                    [&](const GameSettings&, const State&, const JointAction&, const State& after) {
                      const Observation observation = Observe(full_view, after, 3);
                      for (Cell cell = 0; cell < kCellCount; ++cell) {
                        ASSERT_EQ(observation.board[cell], after.ValueAt(cell));
                      }
                    });
}

}  // namespace
}  // namespace powderkeg

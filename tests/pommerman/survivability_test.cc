#include "common/pommerman/survivability.h"

#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <string>

#include "common/base/rng.h"
#include "common/pommerman/step.h"
#include "common/pommerman/symmetry.h"
#include "tests/pommerman/position.h"
#include "tests/pommerman/random_game.h"

namespace powderkeg {
namespace {

// Agent 0 alone, without ammo and kick, among the bombs of a crowded game, all at rest.
State AloneAmongBombs(std::uint64_t seed) {
  const GameSettings settings;
  State state = CrowdedStart(settings, seed);
  Rng rng(seed);
  const int steps = static_cast<int>(rng.Below(12));
  for (int step = 0; step < steps; ++step) Step(settings, RandomActions(rng), state);
  for (AgentState& agent : state.agents) agent.alive = false;
  for (Bomb& bomb : state.Bombs()) bomb.set_direction(Direction::kNone);
  const BitBoard places = ~(state.rigid | state.wood | state.Flames());
  for (Cell cell = static_cast<Cell>(rng.Below(kCellCount));; cell = (cell + 1) % kCellCount) {
    if (!places.Has(cell)) continue;
    state.agents[0] = {.cell = static_cast<std::uint8_t>(cell), .ammo = 0, .alive = true};
    return state;
  }
}

// Every position that agent 0 can come to, by playing them all; then those with a way on to the
// end. The bombs take no notice of it.
class Rollout {
 public:
  explicit Rollout(const State& state) : state_(state) {
    state_.agents[0].alive = false;
    cells_ = Live(state.agents[0].cell, 0, state_);
  }

  [[nodiscard]] const CellsByStep& cells() const { return cells_; }

 private:
  // The pairs through which an agent on `cell` after `step` steps can live to the end.
  CellsByStep Live(Cell cell, int step, State bombs) {
    CellsByStep cells{};
    if (step == kForesight) {
      cells[step].Add(cell);
      return cells;
    }
    for (int number = 0; number <= 4; ++number) {
      State next = bombs;
      next.agents[0] = {.cell = static_cast<std::uint8_t>(cell), .ammo = 0, .alive = true};
      Step(GameSettings(), Actions({static_cast<Action>(number)}), next);
      if (!next.agents[0].alive) continue;
      const Cell reached = next.agents[0].cell;
      next.agents[0].alive = false;
      const CellsByStep& further = Remembered(reached, step + 1, next);
      if (further[step + 1].Empty()) continue;
      for (int i = step + 1; i <= kForesight; ++i) cells[i] |= further[i];
      cells[step].Add(cell);
    }
    return cells;
  }

  const CellsByStep& Remembered(Cell cell, int step, const State& bombs) {
    std::optional<CellsByStep>& known = known_[step][cell];
    if (!known) known = Live(cell, step, bombs);
    return *known;
  }

  State state_;
  std::array<std::array<std::optional<CellsByStep>, kCellCount>, kForesight + 1> known_;
  CellsByStep cells_;
};

int Survivability(const State& state, const CellsByStep& taken = {}) {
  const BombFuture future = ForeseeBombs(GameSettings(), state);
  return CountPairs(SurvivableCells(future, state.agents[0].cell, taken));
}

TEST(Survivability, IsWhatPlayingEveryMoveFinds) {
  int doomed = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const State state = AloneAmongBombs(seed);
    const BombFuture future = ForeseeBombs(GameSettings(), state);
    const CellsByStep cells = SurvivableCells(future, state.agents[0].cell, {});
    ASSERT_EQ(cells, Rollout(state).cells()) << seed << "\n" << ToText(state);
    doomed += CountPairs(cells) == 0 ? 1 : 0;
  }
  EXPECT_GT(doomed, 5) << "some positions should have no way out";
}

TEST(Survivability, IsNoneInADeadEndBehindABomb) {
  const auto dead_end = [](const char* row, const char* bomb) {
    return Survivability(Position({row, "####"}, bomb));
  };
  EXPECT_GT(dead_end("0..#", ""), 0);
  EXPECT_EQ(dead_end("0.o#", "bomb (0,2) owner 1 life 5 strength 3"), 0);
  EXPECT_GT(dead_end("0.o#", "bomb (0,2) owner 1 life 5 strength 2"), 0) << "out of reach";
}

TEST(Survivability, SeesThroughWoodThatBurnsInTime) {
  // The bomb on the right burns the wood, and its flames are gone when the left one goes off.
  const std::string left = "bomb (0,0) owner 1 life 9 strength 3\n";
  EXPECT_EQ(Survivability(Position({"o0+...#", "#######"}, left)), 0);
  EXPECT_GT(Survivability(
                Position({"o0+.o.#", "#######"}, left + "bomb (0,4) owner 1 life 1 strength 3")),
            0);
}

TEST(Survivability, FallsWithABombAndWithWhatOthersTake) {
  const State open = Position({"0"});
  State bombed = open;
  bombed.AddBomb({.cell = CellAt(0, 2), .life = 4, .blast_strength = 4});
  EXPECT_LT(Survivability(bombed), Survivability(open));
  EXPECT_GT(Survivability(bombed), 0);
  CellsByStep taken{};
  int before = Survivability(bombed);
  for (int row = kBoardSize - 1; row > 0; --row) {
    for (BitBoard& cells : taken) cells |= BitBoard::Row(row);
    const int now = Survivability(bombed, taken);
    EXPECT_LT(now, before) << row;
    before = now;
  }
}

TEST(Survivability, TurnsWithTheBoard) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const State state = AloneAmongBombs(seed);
    for (Symmetry symmetry = 0; symmetry < kSymmetryCount; ++symmetry) {
      EXPECT_EQ(Survivability(Transform(symmetry, state)), Survivability(state));
    }
  }
}

TEST(Survivability, KnowsTheCollapse) {
  GameSettings settings;
  settings.collapse_steps = {5, 0, 0, 0};
  const BombFuture future = ForeseeBombs(settings, Position({"0"}));
  const CellsByStep cells = SurvivableCells(future, 0, {});
  EXPECT_EQ(cells[5] & BitBoard::Row(0), BitBoard());
  EXPECT_TRUE(cells[2].Has(CellAt(0, 2)));
}

TEST(ReachableCells, GrowByAStepAndThenStay) {
  const BombFuture future = ForeseeBombs(GameSettings(), Position({"0"}));
  const CellsByStep cells = ReachableCells(future, CellAt(5, 5), /*steps=*/2);
  EXPECT_EQ(cells[0].Count(), 1);
  EXPECT_EQ(cells[1].Count(), 5);
  EXPECT_EQ(cells[2].Count(), 13);
  EXPECT_EQ(cells[kForesight], cells[2]);
}

}  // namespace
}  // namespace powderkeg

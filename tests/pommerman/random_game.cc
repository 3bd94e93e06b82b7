#include "tests/pommerman/random_game.h"

#include <gtest/gtest.h>

#include "common/base/rng.h"
#include "common/pommerman/generate.h"

namespace powderkeg {
namespace {

constexpr std::array kEnvironments = {
    "PommeFFACompetition-v0",  "PommeFFA-v1",  "PommeTeamCompetition-v0",
    "PommeTeamCompetition-v1", "PommeTeam-v0", "PommeRadioCompetition-v2"};

Cell RandomCell(BitBoard cells, Rng& rng) {
  for (std::uint32_t skip = rng.Below(static_cast<std::uint32_t>(cells.Count())); skip > 0;
       --skip) {
    cells.PopFirst();
  }
  return cells.First();
}

// Takes away two walls of three and as much wood; what lies off a small board stays wall.
void OpenUp(int board_size, Rng& rng, State& state) {
  for (BitBoard* cells : {&state.rigid, &state.wood}) {
    ForEachCell(*cells, [&](Cell cell) {
      if (RowOf(cell) >= board_size || ColumnOf(cell) >= board_size) return;
      if (rng.Below(3) == 0) return;
      cells->Remove(cell);
      state.RemoveItems(BitBoard::Of(cell));
      if (rng.Below(8) == 0) state.SetItem(cell, static_cast<Item>(1 + rng.Below(3)));
    });
  }
}

void ScatterBombs(int count, Rng& rng, State& state) {
  for (; count > 0; --count) {
    const BitBoard free = state.Walkable() & ~state.Items();
    if (free.Empty()) return;
    Bomb bomb{.cell = static_cast<std::uint8_t>(RandomCell(free, rng)),
              .life = static_cast<std::int8_t>(1 + rng.Below(9)),
              .blast_strength = static_cast<std::uint8_t>(1 + rng.Below(5))};
    bomb.set_owner(static_cast<AgentId>(rng.Below(kAgentCount)));
    bomb.set_direction(static_cast<Direction>(rng.Below(5)));
    state.AddBomb(bomb);
  }
}

void Equip(Rng& rng, State& state) {
  for (AgentState& agent : state.agents) {
    agent.ammo = static_cast<std::uint8_t>(rng.Below(5));
    agent.blast_strength = static_cast<std::uint8_t>(1 + rng.Below(4));
    agent.can_kick = rng.Below(4) != 0;
  }
}

// Moves more often than bombs, so that games last.
Action RandomAction(Rng& rng) {
  return rng.Below(8) == 0 ? Action::kBomb : static_cast<Action>(rng.Below(5));
}

void PlayGame(const GameSettings& settings, State state, Rng rng, const StepVisitor& visit) {
  for (bool done = false; !done && !testing::Test::HasFatalFailure();) {
    const JointAction actions = RandomActions(rng);
    const State before = state;
    done = Advance(settings, actions, state).done;
    visit(settings, before, actions, state);
  }
}

}  // namespace

State CrowdedStart(const GameSettings& settings, std::uint64_t seed) {
  Rng rng(seed);
  State state = GenerateStart(settings, StartSettings{}, rng.Split(0));
  OpenUp(settings.board_size, rng, state);
  for (AgentState& agent : state.agents) {
    agent.cell = static_cast<std::uint8_t>(RandomCell(state.Walkable() & ~state.Items(), rng));
  }
  Equip(rng, state);
  ScatterBombs(static_cast<int>(rng.Below(12)), rng, state);
  state.step =
      static_cast<std::uint16_t>(rng.Below(static_cast<std::uint32_t>(settings.max_steps)));
  return state;
}

State RandomStart(const GameSettings& settings, std::uint64_t seed) {
  return seed % 2 == 0 ? CrowdedStart(settings, seed)
                       : GenerateStart(settings, StartSettings{}, Rng(seed));
}

JointAction RandomActions(Rng& rng) {
  JointAction actions;
  for (Action& action : actions) action = RandomAction(rng);
  return actions;
}

void ForEachRandomStep(int games_per_setting, const StepVisitor& visit) {
  for (const char* environment : kEnvironments) {
    const GameSettings settings = GameSettingsFor(environment).value();
    for (int game = 0; game < games_per_setting; ++game) {
      const auto seed = static_cast<std::uint64_t>(game);
      PlayGame(settings, RandomStart(settings, seed), Rng(seed).Split(1), visit);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

}  // namespace powderkeg

// Step against the rules written down a second time.

#include <gtest/gtest.h>

#include "common/base/rng.h"
#include "common/pommerman/board_text.h"
#include "common/pommerman/step.h"
#include "tests/pommerman/random_game.h"
#include "tests/pommerman/reference_step.h"

namespace powderkeg {
namespace {

// The step and the reference lead to the same position.
void ExpectAgreement(const GameSettings& settings, const State& before,
                     const JointAction& actions) {
  State stepped = before;
  Step(settings, actions, stepped);
  State reference = before;
  ReferenceStep(settings, actions, reference);
  if (stepped == reference) return;
  std::string played;
  for (const Action action : actions) played += std::to_string(static_cast<int>(action)) + ' ';
  FAIL() << ToText(before) << "actions " << played << "\nstepped\n"
         << ToText(stepped) << "reference\n"
         << ToText(reference);
}

TEST(Differential, RandomGamesAgree) {
  ForEachRandomStep(/*games_per_setting=*/60, [](const GameSettings& settings, const State& before,
                                                 const JointAction& actions, const State&) {
    ExpectAgreement(settings, before, actions);
  });
}

// Everybody in the middle of a small room with rolling bombs: almost every step has a conflict.
State Scrum(Rng& rng) {
  constexpr int kRoom = 4;
  State state;
  for (Cell cell = 0; cell < kCellCount; ++cell) {
    if (RowOf(cell) >= kRoom || ColumnOf(cell) >= kRoom) state.rigid.Add(cell);
  }
  const auto random_cell = [&] {
    return CellAt(static_cast<int>(rng.Below(kRoom)), static_cast<int>(rng.Below(kRoom)));
  };
  for (AgentState& agent : state.agents) {
    Cell cell = random_cell();
    while (state.AgentCells().Has(cell)) cell = random_cell();
    agent = {.cell = static_cast<std::uint8_t>(cell),
             .ammo = static_cast<std::uint8_t>(rng.Below(3)),
             .alive = rng.Below(5) != 0,
             .can_kick = rng.Below(3) != 0};
  }
  for (std::uint32_t count = rng.Below(7); count > 0; --count) {
    Bomb bomb{.cell = static_cast<std::uint8_t>(random_cell()),
              .life = static_cast<std::int8_t>(1 + rng.Below(9)),
              .blast_strength = static_cast<std::uint8_t>(1 + rng.Below(3))};
    bomb.set_owner(static_cast<AgentId>(rng.Below(kAgentCount)));
    bomb.set_direction(static_cast<Direction>(rng.Below(5)));
    if (!state.bomb_cells.Has(bomb.cell)) state.AddBomb(bomb);
  }
  for (std::uint32_t count = rng.Below(5); count > 0; --count) {
    const Cell cell = random_cell();
    if ((state.AgentCells() | state.bomb_cells | state.Items()).Has(cell)) continue;
    switch (rng.Below(3)) {
      case 0: state.wood.Add(cell); break;
      case 1: state.flames[rng.Below(3)].Add(cell); break;
      default: break;
    }
    if (rng.Below(2) == 0) state.SetItem(cell, static_cast<Item>(1 + rng.Below(3)));
  }
  state.wood &= ~state.Flames();
  return state;
}

TEST(Differential, ScrumsAgree) {
  Rng rng(2024);
  for (int scrum = 0; scrum < 60000 && !HasFatalFailure(); ++scrum) {
    const State state = Scrum(rng);
    JointAction actions;
    for (Action& action : actions) action = static_cast<Action>(rng.Below(kActionCount));
    ExpectAgreement(GameSettings{}, state, actions);
  }
}

}  // namespace
}  // namespace powderkeg

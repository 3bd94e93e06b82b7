#include "actors/pessimist/pessimist.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "actors/play/plain_agents.h"
#include "common/pommerman/symmetry.h"
#include "common/record/game_setup.h"
#include "tests/play/support.h"
#include "tests/pommerman/board_reader.h"
#include "tests/pommerman/random_game.h"

namespace powderkeg {
namespace {

const GameSettings kFreeForAll;
const GameSettings kTeam = GameSettingsFor("PommeTeam-v0").value();

// These rows above free ones.
State Board(const std::string& first, const std::string& second, const std::string& attributes) {
  std::string text = first + "\n" + second + "\n";
  for (int row = 2; row < kBoardSize; ++row) text += "...........\n";
  return FromText(text + attributes);
}

State After(State state, Action action) {
  Step(kFreeForAll, {action}, state);
  return state;
}

Action Chosen(const State& state, const GameSettings& game = kFreeForAll) {
  Rng rng(1);
  return Pessimist(PessimistSettings()).Choose(game, state, 0, BitBoard::All(), rng);
}

// Positions of random games in which agent 0 lives.
template <typename Visit>
void ForEachPosition(int games, const Visit& visit) {
  for (int game = 0; game < games; ++game) {
    State state = RandomStart(kFreeForAll, static_cast<std::uint64_t>(game));
    Rng rng(static_cast<std::uint64_t>(game));
    for (int step = 0; step < 30 && state.agents[0].alive; ++step) {
      visit(state);
      Step(kFreeForAll, RandomActions(rng), state);
    }
  }
}

int Survivability(const State& state) {
  const BombFuture future = ForeseeBombs(kFreeForAll, state);
  return CountPairs(SurvivableCells(future, state.agents[0].cell, {}));
}

TEST(Pessimist, PlaysLegalActionsAndTheSameForTheSameGenerator) {
  Pessimist first{PessimistSettings()};
  Pessimist second{PessimistSettings()};
  ForEachPosition(20, [&](const State& state) {
    Rng rng(state.step);
    Rng same(state.step);
    const Action action = first.Choose(kFreeForAll, state, 0, BitBoard::All(), rng);
    EXPECT_TRUE(Has(LegalActions(state, 0), static_cast<std::size_t>(action)));
    EXPECT_EQ(second.Choose(kFreeForAll, state, 0, BitBoard::All(), same), action);
  });
}

TEST(Pessimist, ThinksTheSameOfATurnedBoard) {
  Pessimist pessimist{PessimistSettings()};
  ForEachPosition(6, [&](const State& state) {
    if (state.step % 5 != 0) return;
    const auto values = pessimist.Values(kFreeForAll, state, 0, BitBoard::All());
    for (Symmetry symmetry = 0; symmetry < kSymmetryCount; ++symmetry) {
      const State turned = Transform(symmetry, state);
      const auto others = pessimist.Values(kFreeForAll, turned, 0, BitBoard::All());
      for (std::size_t action = 0; action < values.size(); ++action) {
        const Action image = Transform(symmetry, static_cast<Action>(action));
        EXPECT_EQ(others[static_cast<std::size_t>(image)], values[action]) << ToText(state);
      }
    }
  });
}

TEST(Pessimist, StaysAliveWhereItCan) {
  int in_danger = 0;
  ForEachPosition(60, [&](State state) {
    for (AgentId id = 1; id < kAgentCount; ++id) state.agents[id].alive = false;
    state.agents[0].can_kick = false;
    for (Bomb& bomb : state.Bombs()) bomb.set_direction(Direction::kNone);
    const int before = Survivability(state);
    const bool endangered = std::ranges::any_of(kDirections, [&](Direction direction) {
      const State next = After(state, ActionOf(direction));
      return !next.agents[0].alive || Survivability(next) == 0;
    });
    if (before == 0 || !endangered) return;
    ++in_danger;
    const State next = After(state, Chosen(state));
    EXPECT_TRUE(next.agents[0].alive && Survivability(next) > 0) << ToText(state);
  });
  EXPECT_GT(in_danger, 30);
}

// Whoever is in the dead end on the left has no way past a bomb at its mouth.
State DeadEnd(const std::string& inhabitant) {
  return Board(inhabitant + "..0.......", "###........", "agent 0 ammo 1 strength 4");
}

// Agent 0 plays as a pessimist, agent 1 what is legal other than bombs.
State AfterFight(State state, const GameSettings& game, int steps) {
  Pessimist pessimist{PessimistSettings()};
  Rng rng(1);
  PolicyMemory memory;
  for (int step = 0; step < steps && state.agents[0].alive; ++step) {
    const Action own = pessimist.Choose(game, state, 0, BitBoard::All(), rng);
    const PolicyView view{state, game, 1};
    const Action other = state.agents[1].alive
                             ? Decide(PolicyKind::kHarmless, view, {}, memory, rng)
                             : Action::kStop;
    Step(game, {own, other}, state);
  }
  return state;
}

TEST(Pessimist, TrapsAnEnemyInADeadEnd) {
  for (const GameSettings& game : {kFreeForAll, kTeam}) {
    const State end = AfterFight(DeadEnd("1"), game, /*steps=*/13);
    EXPECT_FALSE(end.agents[1].alive);
    EXPECT_TRUE(end.agents[0].alive);
  }
}

TEST(Pessimist, LetsItsMateLive) {
  State state = DeadEnd("2");
  Pessimist pessimist{PessimistSettings()};
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Rng rng(seed);
    EXPECT_NE(pessimist.Choose(kTeam, state, 0, BitBoard::All(), rng), Action::kBomb);
  }
}

TEST(Pessimist, OpensWoodAndGoesForItems) {
  const std::string free = "...........";
  EXPECT_EQ(Chosen(Board(free, "..0+.......", "")), Action::kBomb);
  EXPECT_EQ(Chosen(Board(free, "..0.k......", "")), Action::kRight);
}

TEST(PessimistAgent, SaysWhereItIs) {
  const GameSettings radio = GameSettingsFor("PommeRadioCompetition-v2").value();
  PessimistAgent agent{PessimistSettings()};
  agent.StartGame(radio, /*self=*/0, Rng(1));
  State state = DeadEnd("1");
  state.step = 4;
  agent.Begin(Observe(radio, state, 0));
  EXPECT_EQ(agent.words(), EncodeReport(4, state.agents[0].cell, agent.action()));
}

// As a run plays them: named in a line-up, and as a player that teaches its moves.
TEST(PessimistAgent, PlaysGamesThatVerify) {
  SelfPlayConfig config;
  config.environment = "PommeRadioCompetition-v2";
  config.players = {{.name = "teacher", .agent = "pessimist", .teaches = Teaches::kMoves}};
  config.lineups = {{.seats = {"teacher", "pessimist", "simple_unbiased", "pessimist"}}};
  const RunGames games(config);
  for (std::uint64_t ticket = 0; ticket < 3; ++ticket) {
    GamePlan plan{.ticket = ticket, .setup = games.SetupFor(ticket), .agents = {}};
    std::array<PessimistAgent, kAgentCount> agents = {PessimistAgent({}), PessimistAgent({}),
                                                      PessimistAgent({}), PessimistAgent({})};
    for (std::size_t seat = 0; seat < kAgentCount; ++seat) {
      if (!plan.setup.seats[seat].searches) continue;
      plan.agents[seat] = {&agents[seat], {std::make_shared<UniformEvaluator>(), 0}};
    }
    const GameRecord record = PlayGame(plan);
    EXPECT_EQ(Verify(record), std::nullopt);
    EXPECT_EQ(PlayGame(plan), record) << "the same again";
  }
}

}  // namespace
}  // namespace powderkeg

#include "common/pommerman/belief.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "common/pommerman/generate.h"
#include "common/record/rule_based_seat.h"
#include "common/recorded/recorded_game.h"
#include "tests/pommerman/position.h"
#include "tests/pommerman/random_game.h"

namespace powderkeg {
namespace {

using enum Action;

const GameSettings kFullView;
const GameSettings kFog = GameSettingsFor("PommeTeamCompetition-v0").value();

// A game of four SimpleUnbiased agents; visit(state, before) sees every position as it is observed,
// before a collapse, and the one before its step.
template <typename Visit>
void PlayGame(const GameSettings& settings, std::uint64_t seed, Visit&& visit) {
  GameSetup setup;
  setup.settings = settings;
  setup.start.corners = seed % 2 == 0 ? StartCorners::kOfficial : StartCorners::kPermuted;
  setup.seed = seed;
  setup.seats.fill({.searches = false, .policy = PolicyKind::kSimpleUnbiased});
  std::array<RuleBasedSeat, kAgentCount> seats;
  for (AgentId id = 0; id < kAgentCount; ++id) seats[id] = RuleBasedSeat(setup, id);
  State state = GenerateStart(settings, setup.start, BoardRng(setup));
  State before = state;
  visit(state, before);
  while (!OutcomeOf(settings, state).done && !testing::Test::HasFatalFailure()) {
    const State observed = state;
    Collapse(settings, state);
    JointAction actions{};
    for (AgentId id = 0; id < kAgentCount; ++id) {
      if (state.agents[id].alive) actions[id] = seats[id].Decide(settings, observed);
    }
    before = state;
    Step(settings, actions, state);
    visit(state, before);
  }
}

State WithoutHiddenItems(State state) {
  state.RemoveItems(state.HiddenItems());
  return state;
}

// Whether an agent picked up what nobody ever saw: an item that came out of the flames in this
// step.
bool PicksUpUnseen(const State& before, const State& after, AgentId id) {
  const Cell cell = after.agents[id].cell;
  return after.agents[id].alive && before.flames[0].Has(cell) && before.Items().Has(cell);
}

TEST(BeliefTest, FullViewOfAFreeForAllIsTheTruthButForHiddenThings) {
  int steps = 0, secrets = 0;
  for (const char* environment : {"PommeFFACompetition-v0", "PommeFFA-v1", "PommeTeam-v0"}) {
    const GameSettings settings = GameSettingsFor(environment).value();
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      Belief belief(settings);
      std::array<bool, kAgentCount> has_secret{};
      PlayGame(settings, seed, [&](const State& state, const State& before) {
        belief.Observe(Observe(settings, state, 1));
        State truth = WithoutHiddenItems(state);
        Collapse(settings, truth);
        truth.agents[1].alive = state.agents[1].alive;
        ++steps;
        for (AgentId id = 0; id < kAgentCount; ++id) {
          if (PicksUpUnseen(before, state, id) && !has_secret[id]) {
            has_secret[id] = true;
            ++secrets;
          }
          // Where in the flames an agent died is not shown either.
          if (truth.agents[id].alive && (!has_secret[id] || id == 1)) continue;
          ASSERT_EQ(belief.state().agents[id].alive, truth.agents[id].alive);
          truth.agents[id] = belief.state().agents[id];
        }
        ASSERT_EQ(ToText(belief.state()), ToText(truth)) << environment << " seed " << seed;
        ASSERT_EQ(belief.state(), truth);
      });
    }
  }
  std::printf("%d steps, %d secret pick-ups\n", steps, secrets);
}

// Kicks, bounces and chains of bombs, whose owners nobody could know from the start position.
TEST(BeliefTest, FullViewOfACrowdedBoardIsTheTruth) {
  Rng rng(1);
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    State state = CrowdedStart(kFullView, seed);
    Belief belief(kFullView);
    belief.Observe(Observe(kFullView, state, 0));
    while (!OutcomeOf(kFullView, state).done) {
      JointAction actions{};
      for (Action& action : actions) action = static_cast<Action>(rng.Below(kActionCount));
      Step(kFullView, actions, state);
      const Observation seen = Observe(kFullView, state, 0);
      belief.Observe(seen);
      ASSERT_EQ(Observe(kFullView, belief.state(), 0), seen) << ToText(state);
    }
  }
}

void ExpectInvariants(const State& state) {
  BitBoard agents;
  for (const AgentState& agent : state.agents) {
    if (!agent.alive) continue;
    EXPECT_FALSE(agents.Has(agent.cell));
    agents.Add(agent.cell);
  }
  const BitBoard blocked = state.rigid | state.wood | state.Flames();
  EXPECT_TRUE((agents & (blocked | state.Items())).Empty());
  EXPECT_TRUE((state.bomb_cells & blocked).Empty());
  EXPECT_TRUE(state.HiddenItems().Empty());
  BitBoard bombs;
  for (const Bomb& bomb : state.Bombs()) bombs.Add(bomb.cell);
  EXPECT_EQ(state.bomb_cells, bombs);
  EXPECT_EQ(bombs.Count(), state.bomb_count);
}

TEST(BeliefTest, TheTruthAsSeenTeachesWhatItsObservationTeaches) {
  Rng words(1);
  for (const GameSettings& settings :
       {kFullView, kFog, GameSettingsFor("PommeRadioCompetition-v2").value(),
        GameSettingsFor("OneVsOne-v0").value_or(kFog)}) {
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
      std::array<Belief, kAgentCount> told = {Belief(settings), Belief(settings), Belief(settings),
                                              Belief(settings)};
      std::array<Belief, kAgentCount> shown = told;
      State state = seed % 2 == 0 ? RandomStart(settings, seed) : CrowdedStart(settings, seed);
      Rng rng(seed);
      for (int step = 0; step < 150 && !OutcomeOf(settings, state).done; ++step) {
        for (Message& message : state.messages) {
          for (auto& word : message) word = static_cast<std::uint8_t>(words.Below(9));
        }
        for (AgentId id = 0; id < kAgentCount; ++id) {
          told[id].Observe(Observe(settings, state, id));
          shown[id].Observe(state, id);
          ASSERT_EQ(told[id].state(), shown[id].state()) << seed << " " << step << " " << id;
          ASSERT_EQ(told[id].visible(), shown[id].visible());
        }
        Collapse(settings, state);
        Step(settings, RandomActions(rng), state);
      }
    }
  }
}

TEST(BeliefTest, UnderFogItShowsWhatIsSeenAndKeepsTheInvariants) {
  for (std::uint64_t seed = 0; seed < 16; ++seed) {
    Belief belief(kFog);
    PlayGame(kFog, seed, [&](const State& truth, const State&) {
      if (!truth.agents[2].alive) return;
      const Observation seen = Observe(kFog, truth, 2);
      belief.Observe(seen);
      ASSERT_EQ(Observe(kFog, belief.state(), 2), seen);
      ExpectInvariants(belief.state());
      ASSERT_FALSE(::testing::Test::HasNonfatalFailure()) << "truth\n"
                                                          << ToText(truth) << "believed\n"
                                                          << ToText(belief.state());
    });
  }
}

// How close a belief is to the truth, summed over observations.
struct Closeness {
  int remembered_cells = 0, remembered_right = 0;  // seen before, out of sight now
  int bombs = 0, right_owners = 0;                 // in view
  int unseen_agents = 0, distance = 0;
  int others = 0, right_ammo = 0, right_strength = 0, right_kick = 0;
};

void Compare(const State& truth, const Belief& belief, Closeness& sums) {
  const State& state = belief.state();
  ForEachCell(belief.ever_seen() & ~belief.visible(), [&](Cell cell) {
    const bool right = truth.rigid.Has(cell) == state.rigid.Has(cell) &&
                       truth.wood.Has(cell) == state.wood.Has(cell) &&
                       truth.Flames().Has(cell) == state.Flames().Has(cell);
    ++sums.remembered_cells;
    sums.remembered_right += right;
  });
  for (const Bomb& bomb : truth.Bombs()) {
    if (!belief.visible().Has(bomb.cell)) continue;
    ++sums.bombs;
    sums.right_owners += state.BombAt(bomb.cell)->owner() == bomb.owner();
  }
  for (AgentId id = 0; id < kAgentCount; ++id) {
    const AgentState& agent = truth.agents[id];
    if (id == belief.self() || !agent.alive) continue;
    ++sums.others;
    sums.right_ammo += agent.ammo == state.agents[id].ammo;
    sums.right_strength += agent.blast_strength == state.agents[id].blast_strength;
    sums.right_kick += agent.can_kick == state.agents[id].can_kick;
    if (belief.visible().Has(agent.cell)) continue;
    ++sums.unseen_agents;
    sums.distance += ManhattanDistance(agent.cell, state.agents[id].cell);
  }
}

double Share(int part, int whole) { return static_cast<double>(part) / whole; }

TEST(BeliefTest, IsCloseToTheTruthInRecordedTeamGames) {
  RecordedGameReader reader("tests/data/team.jsonl.gz");
  Closeness sums;
  for (RecordedGame game; reader.Next(game);) {
    for (AgentId id = 0; id < kAgentCount; ++id) {
      Belief belief(game.settings);
      belief.Observe(Observe(game.settings, game.start, id));
      for (const RecordedStep& step : game.steps) {
        if (!step.state.agents[id].alive) break;
        belief.Observe(Observe(game.settings, step.state, id));
        Compare(step.state, belief, sums);
      }
    }
  }
  const double cells = Share(sums.remembered_right, sums.remembered_cells);
  const double owners = Share(sums.right_owners, sums.bombs);
  const double distance = Share(sums.distance, sums.unseen_agents);
  const double ammo = Share(sums.right_ammo, sums.others);
  const double strength = Share(sums.right_strength, sums.others);
  const double kick = Share(sums.right_kick, sums.others);
  std::printf(
      "remembered cells right %.4f, owners of bombs in view %.4f, mean distance of unseen agents "
      "%.2f, others' ammo %.3f strength %.3f kick %.3f\n",
      cells, owners, distance, ammo, strength, kick);
  EXPECT_GT(cells, 0.96);
  EXPECT_GT(owners, 0.98);
  EXPECT_LT(distance, 2.8);
  EXPECT_GT(strength, 0.7);
}

// The belief of agent 0 that sees these positions in consecutive steps.
Belief BeliefAfter(const GameSettings& settings, std::initializer_list<State> positions) {
  Belief belief(settings);
  std::uint16_t step = 0;
  for (State position : positions) {
    position.step = step++;
    belief.Observe(Observe(settings, position, 0));
  }
  return belief;
}

TEST(BeliefTest, StartsWithTheCornersOfThoseOutOfSight) {
  const State start = Position({"", ".0.......3", "", "", "", "", "", "", "", ".1.......2"});
  const Belief belief = BeliefAfter(kFog, {start});
  EXPECT_EQ(belief.self(), 0);
  EXPECT_EQ(belief.state().agents[1].cell, CellAt(9, 1));
  EXPECT_EQ(belief.state().agents[2].cell, CellAt(9, 9));
  EXPECT_EQ(belief.state().agents[3].cell, CellAt(1, 9));
  EXPECT_EQ(belief.visible().Count(), 6 * 6);
  EXPECT_EQ(belief.ever_seen(), belief.visible());
}

TEST(BeliefTest, PermutedCornersAreSwappedWithTheOwner) {
  const State start = Position({"", ".2.......3", "", "", "", "", "", "", "", ".1.......0"});
  const Belief belief = BeliefAfter(kFog, {start});
  EXPECT_EQ(belief.state().agents[0].cell, CellAt(9, 9));
  EXPECT_EQ(belief.state().agents[1].cell, CellAt(9, 1));
  EXPECT_EQ(belief.state().agents[2].cell, CellAt(1, 1));
}

TEST(BeliefTest, KnowsThePickUpsOfOthers) {
  const State start = Position({"0", "", "1r2k3b"});
  const State next = After(start, {kStop, kRight, kRight, kRight});
  const Belief belief = BeliefAfter(kFullView, {start, next});
  EXPECT_EQ(belief.state().agents[1].blast_strength, 3);
  EXPECT_TRUE(belief.state().agents[2].can_kick);
  EXPECT_EQ(belief.state().agents[3].ammo, 2);
}

TEST(BeliefTest, LearnsKickAndStrengthFromWhatOthersDo) {
  const State start = Position({"0", "", "1o", "", "2"}, "agent 1 kick\nagent 2 ammo 2 strength 5");
  const State next = After(start, {kStop, kRight, kBomb});
  const Belief belief = BeliefAfter(kFullView, {start, next});
  EXPECT_TRUE(belief.state().agents[1].can_kick);
  EXPECT_FALSE(belief.state().agents[2].can_kick);
  EXPECT_EQ(belief.state().agents[2].blast_strength, 5);
  EXPECT_EQ(belief.state().agents[2].ammo, 0);
  EXPECT_EQ(belief.state().BombAt(CellAt(4, 0))->owner(), 2);
}

TEST(BeliefTest, AmmoComesBackWithTheExplosion) {
  State state = Position({"0", "", "", "", "......1", "......2"});
  Belief belief(kFullView);
  belief.Observe(Observe(kFullView, state, 0));
  state = After(state, {kStop, kBomb, kRight});
  belief.Observe(Observe(kFullView, state, 0));
  EXPECT_EQ(belief.state().agents[1].ammo, 0);
  for (const Action action : {kUp, kLeft, kLeft, kLeft, kStop, kStop, kStop, kStop, kStop}) {
    EXPECT_EQ(belief.state().agents[1].ammo, 0);
    state = After(state, {kStop, action, kRight});
    belief.Observe(Observe(kFullView, state, 0));
  }
  EXPECT_EQ(state.bomb_count, 0);
  EXPECT_EQ(belief.state().agents[1].ammo, 1);
}

TEST(BeliefTest, ABombOfUnknownOriginIsTheNearestOthers) {
  const State state = Position({"0.o.1......", "..........2"}, "bomb (0,2) owner 0 life 5");
  const Belief belief = BeliefAfter(kFullView, {state});
  EXPECT_EQ(belief.state().bombs[0].owner(), 1);
  EXPECT_EQ(belief.state().agents[1].ammo, 0);
  EXPECT_EQ(belief.state().agents[2].ammo, 1);
}

TEST(BeliefTest, BombsOutOfSightRollAndExplode) {
  // Agent 0 sees columns 0 to 4; the bomb rolls out of sight and explodes there.
  State truth = Position({"0...o......", "....1"}, "bomb (0,4) owner 1 life 3 moving right");
  Belief belief(kFog);
  belief.Observe(Observe(kFog, truth, 0));
  for (int i = 0; i < 2; ++i) {
    truth = After(truth, {}, kFog);
    belief.Observe(Observe(kFog, truth, 0));
    ASSERT_EQ(belief.state().bomb_count, 1);
    EXPECT_EQ(belief.state().bombs[0], truth.bombs[0]);
    EXPECT_FALSE(belief.visible().Has(truth.bombs[0].cell));
  }
  truth = After(truth, {}, kFog);
  belief.Observe(Observe(kFog, truth, 0));
  EXPECT_EQ(belief.state().bomb_count, 0);
  EXPECT_EQ(belief.state().flames[2], truth.flames[2]);
}

TEST(BeliefTest, RemembersABombOutOfSight) {
  const State far = Position({"0...o#"}, "bomb (0,4) owner 1 life 9");
  State away = After(far, {});
  away.agents[0].cell = CellAt(9, 0);
  const Belief remembering = BeliefAfter(kFog, {far, away});
  EXPECT_EQ(remembering.state().bomb_count, 1);
  EXPECT_TRUE(remembering.ever_seen().Has(0));
}

TEST(BeliefTest, AnAgentThatIsNotWhereItWasBelievedIsOutOfSight) {
  const State seen = Position({"0.1"});
  State gone = seen;
  gone.agents[1].cell = CellAt(10, 10);
  const Belief belief = BeliefAfter(kFog, {seen, gone});
  EXPECT_TRUE(belief.state().agents[1].alive);
  EXPECT_EQ(belief.state().agents[1].cell, CellAt(0, 5));
}

TEST(BeliefTest, AnAgentKnownToLiveIsNotWhereABombExplodedOutOfSight) {
  // Both the bomb and agent 1 beside it are last seen in column 4.
  State truth = Position({"0...o......", "....1"}, "bomb (0,4) owner 1 life 2");
  Belief belief(kFog);
  belief.Observe(Observe(kFog, truth, 0));
  truth.agents[0].cell = CellAt(9, 0);
  truth = After(truth, {kStop, kRight}, kFog);
  belief.Observe(Observe(kFog, truth, 0));
  truth = After(truth, {kStop, kRight}, kFog);
  belief.Observe(Observe(kFog, truth, 0));
  EXPECT_TRUE(belief.state().flames[2].Has(CellAt(1, 4)));
  EXPECT_TRUE(belief.state().agents[1].alive);
  EXPECT_FALSE(belief.state().Flames().Has(belief.state().agents[1].cell));
}

TEST(BeliefTest, AMissedObservationLosesNothingInView) {
  State truth = Position({"0..1"});
  Belief belief(kFullView);
  belief.Observe(Observe(kFullView, truth, 0));
  truth = After(After(After(truth, {kStop, kBomb}), {kStop, kDown}), {kStop, kDown});
  belief.Observe(Observe(kFullView, truth, 0));
  EXPECT_EQ(Observe(kFullView, belief.state(), 0), Observe(kFullView, truth, 0));
  EXPECT_EQ(belief.state().bombs[0].owner(), 1);
  EXPECT_EQ(belief.state().agents[1].ammo, 0);
}

const GameSettings kRadio = GameSettingsFor("PommeRadioCompetition-v2").value();

// What agent 0 believes of a position that lasts, while its mate says that it is on `said`.
Belief BeliefTold(State truth, Cell said, const GameSettings& settings = kRadio) {
  Belief belief(settings);
  for (std::uint16_t step = 0; step < 3; ++step) {
    truth.step = step;
    Observation seen = Observe(settings, truth, 0);
    if (step > 0) seen.message = EncodeReport(step - 1, said, kStop);
    belief.Observe(seen);
  }
  return belief;
}

TEST(BeliefTest, AMateOutOfSightIsWhereItSaysItIs) {
  const State truth = Position({"0", "", "", "", "", "", "", "", "", ".........2"});
  const Belief belief = BeliefTold(truth, CellAt(3, 8));
  EXPECT_EQ(belief.state().agents[2].cell, CellAt(3, 8));
  EXPECT_EQ(belief.state().messages, State().messages) << "words are no part of the position";
}

TEST(BeliefTest, AMateIsBelievedOnTheNearestCellWhereItCanBe) {
  // Agent 0 sees rows and columns 0 to 4.
  const State truth = Position({"0.........3", "", "..........2"});
  const auto believed = [&](Cell said) {
    return Cell{BeliefTold(truth, said).state().agents[2].cell};
  };
  EXPECT_EQ(believed(CellAt(3, 2)), CellAt(5, 2)) << "in view, where it is not";
  EXPECT_EQ(believed(CellAt(0, 5)), CellAt(0, 5));
  const Cell other = BeliefTold(truth, CellAt(0, 5)).state().agents[3].cell;
  EXPECT_EQ(ManhattanDistance(believed(other), other), 1);
}

TEST(BeliefTest, WordsDoNotMoveAMateInViewADeadOneOrAnEnemy) {
  EXPECT_EQ(BeliefTold(Position({"0.2"}), CellAt(9, 9)).state().agents[2].cell, CellAt(0, 2));
  const State mourning = Position({"0.........1"});
  EXPECT_EQ(BeliefTold(mourning, CellAt(9, 9)).state(), BeliefTold(mourning, 0).state());
  const State alone = Position({"0.........2"});
  EXPECT_EQ(BeliefTold(alone, CellAt(9, 9), kFullView).state().agents[2].cell, CellAt(0, 10));
}

TEST(BeliefTest, AMateInViewElsewhereThanItSaysIsNotBelieved) {
  Belief belief(kRadio);
  State truth = Position({"0.2"});
  for (std::uint16_t step = 0; step < 8; ++step) {
    truth.step = step;
    if (step == 4) truth.agents[2].cell = CellAt(0, 5);  // just out of sight
    Observation seen = Observe(kRadio, truth, 0);
    if (step > 0) seen.message = EncodeReport(step - 1, CellAt(9, 9), kStop);
    belief.Observe(seen);
  }
  EXPECT_LT(ManhattanDistance(belief.state().agents[2].cell, CellAt(0, 2)), 5);
}

TEST(BeliefTest, WhateverTheMateSaysTheInvariantsHold) {
  Rng rng(4);
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    Belief belief(kRadio);
    PlayGame(kRadio, seed, [&](const State& truth, const State&) {
      if (!truth.agents[2].alive) return;
      Observation seen = Observe(kRadio, truth, 2);
      const auto word = [&] { return static_cast<std::uint8_t>(rng.Below(8)); };
      seen.message = {word(), word()};
      belief.Observe(seen);
      seen.message = {};
      ASSERT_EQ(Observe(kRadio, belief.state(), 2), seen);
      ExpectInvariants(belief.state());
      ASSERT_FALSE(::testing::Test::HasNonfatalFailure()) << ToText(belief.state());
    });
  }
}

TEST(BeliefTest, ReportsWhereItsAgentIs) {
  const Belief belief = BeliefAfter(kRadio, {Position({"0"}), Position({".0"})});
  EXPECT_EQ(belief.Report(kDown), EncodeReport(1, CellAt(0, 1), kDown));
}

TEST(BeliefTest, KnowsTheBoardAfterACollapse) {
  GameSettings settings = kFullView;
  settings.collapse_steps = {1, 0, 0, 0};
  State state = Position({"0", "", "..1"});
  Belief belief(settings);
  belief.Observe(Observe(settings, state, 1));
  EXPECT_FALSE(belief.state().rigid.Has(0));
  state = After(state, {}, settings);
  belief.Observe(Observe(settings, state, 1));
  EXPECT_TRUE(belief.state().rigid.Has(0));
  EXPECT_FALSE(belief.state().agents[0].alive);
  EXPECT_TRUE(belief.state().agents[1].alive);
}

}  // namespace
}  // namespace powderkeg

#include "actors/play/step_events.h"

#include <gtest/gtest.h>

#include "common/pommerman/generate.h"
#include "common/pommerman/step.h"
#include "tests/pommerman/board_reader.h"

namespace powderkeg {
namespace {

constexpr Action kStop = Action::kStop;

constexpr AgentSet Set(std::initializer_list<AgentId> agents) {
  AgentSet set = 0;
  for (const AgentId agent : agents) set = static_cast<AgentSet>(set | 1 << agent);
  return set;
}

// A board whose first row is given, followed by what ToText writes below a board.
State Row(const std::string& row, const std::string& attributes) {
  std::string text = row + "\n";
  for (int i = 1; i < kBoardSize; ++i) text += "...........\n";
  return FromText(text + attributes);
}

// Plays the steps on the state and returns the events of the last one.
StepEvents PlayOn(StepWatcher& watcher, State& state, const std::vector<JointAction>& steps) {
  StepEvents events;
  for (const JointAction& actions : steps) {
    const State before = state;
    Step(GameSettings(), actions, state);
    events = watcher.Watch(GameSettings(), before, actions, state);
  }
  return events;
}

StepEvents Play(State state, const std::vector<JointAction>& steps) {
  StepWatcher watcher;
  return PlayOn(watcher, state, steps);
}

constexpr JointAction kRest = {kStop, kStop, kStop, kStop};

TEST(StepWatcher, SeesNothingWhereNothingHappens) {
  EXPECT_EQ(Play(Row("0.1.2.3....", ""), {{Action::kDown, kStop, kStop, kStop}}), StepEvents());
}

TEST(StepWatcher, SeesBombsThatWereReallyLaid) {
  const State state = Row("0.1.2.3....", "agent 1 ammo 0\nagent 2 ammo 1\nbomb (0,4) owner 3\n");
  const JointAction all = {Action::kBomb, Action::kBomb, Action::kBomb, Action::kBomb};
  EXPECT_EQ(Play(state, {all}).laid, Set({0, 3}));  // 1 has none left, 2 stands on a bomb
  EXPECT_EQ(Play(state, {all, all}).laid, Set({}));
}

// The flames of a bomb that lasted a step only, set off where it was laid.
TEST(StepWatcher, SeesABombThatWasSetOffAtOnce) {
  const State state = Row("0o.......1.", "bomb (0,1) owner 1 life 1 strength 2\n");
  const StepEvents events = Play(state, {{Action::kBomb, kStop, kStop, kStop}});
  EXPECT_EQ(events.laid, Set({0}));
  EXPECT_EQ(events.burnt, Set({0}));
  EXPECT_EQ(events.killers[0], Set({0, 1}));
}

TEST(StepWatcher, SeesAKickOnceAndNotTheRolling) {
  const State state = Row("0o.......1.", "agent 0 ammo 0 kick\n");
  const JointAction right = {Action::kRight, kStop, kStop, kStop};
  EXPECT_EQ(Play(state, {right}).kicked, Set({0}));
  EXPECT_EQ(Play(state, {right, right}).kicked, Set({}));  // walks behind the bomb
  EXPECT_EQ(Play(state, {right, kRest}).kicked, Set({}));
}

TEST(StepWatcher, SeesNoKickWhereTheBombStays) {
  const JointAction right = {Action::kRight, kStop, kStop, kStop};
  EXPECT_EQ(Play(Row("0o.......1.", ""), {right}).kicked, Set({}));
  EXPECT_EQ(Play(Row("0o1........", "agent 0 kick\n"), {right}).kicked, Set({}));
  EXPECT_EQ(Play(Row("0o#......1.", "agent 0 kick\n"), {right}).kicked, Set({}));
}

TEST(StepWatcher, SeesAKickAgainstARollingBomb) {
  const State state = Row("0.o......1.", "agent 0 kick\nbomb (0,2) owner 1 moving left\n");
  EXPECT_EQ(Play(state, {{Action::kRight, kStop, kStop, kStop}}).kicked, Set({0}));
}

TEST(StepWatcher, SeesTheKickOfABombThatExplodesInTheSameStep) {
  const State state = Row("0o.1.......", "agent 0 kick\nbomb (0,1) owner 2 life 1 strength 2\n");
  const StepEvents events = Play(state, {{Action::kRight, kStop, kStop, kStop}});
  EXPECT_EQ(events.kicked, Set({0}));
  EXPECT_EQ(events.burnt, Set({0, 1}));  // it went off on (0,2)
  EXPECT_EQ(events.killers[0], Set({2}));
  EXPECT_EQ(events.killers[1], Set({2}));
}

// What lies in flames stands in no bomb's way, and they set it off.
TEST(StepWatcher, SeesAKickIntoFlamesThatHideAnItem) {
  const State state =
      Row("0o*.......1", "agent 0 kick\nbomb (0,1) owner 2\nflame (0,2) life 2\nhidden (0,2) r\n");
  const StepEvents events = Play(state, {{Action::kRight, kStop, kStop, kStop}});
  EXPECT_EQ(events.kicked, Set({0}));
  EXPECT_EQ(events.killers[0], Set({2}));
}

TEST(StepWatcher, GivesADeathToTheOwnerOfTheBlast) {
  const State state = Row("0.o.1......", "bomb (0,2) owner 2 life 1 strength 3\n");
  const StepEvents events = Play(state, {kRest});
  EXPECT_EQ(events.burnt, Set({0, 1}));
  EXPECT_EQ(events.killers, (std::array<AgentSet, 4>{Set({2}), Set({2}), 0, 0}));
}

TEST(StepWatcher, GivesADeathToAllWhoseBlastsMet) {
  const State state = Row("o0o........",
                          "bomb (0,0) owner 0 life 1 strength 2\n"
                          "bomb (0,2) owner 3 life 5 strength 3\n");
  EXPECT_EQ(Play(state, {kRest}).killers[0], Set({0}));  // strength 2 ends before the other bomb
  const State chain = Row("o0o........",
                          "bomb (0,0) owner 0 life 1 strength 3\n"
                          "bomb (0,2) owner 3 life 5 strength 3\n");
  EXPECT_EQ(Play(chain, {kRest}).killers[0], Set({0, 3}));
}

// In a chain the flames are those of each bomb, not of whoever began it.
TEST(StepWatcher, GivesADeathInAChainToTheBombThatReached) {
  const State state = Row("o.o...1....",
                          "bomb (0,0) owner 0 life 1 strength 3\n"
                          "bomb (0,2) owner 3 life 5 strength 5\n");
  const StepEvents events = Play(state, {kRest});
  EXPECT_EQ(events.burnt, Set({1}));
  EXPECT_EQ(events.killers[1], Set({3}));
}

TEST(StepWatcher, RemembersWhoseFlamesStillBurn) {
  const State state = Row("o..1.......", "bomb (0,0) owner 2 life 1 strength 3\n");
  const JointAction left = {kStop, Action::kLeft, kStop, kStop};
  const StepEvents second = Play(state, {kRest, left});
  EXPECT_EQ(second.burnt, Set({1}));
  EXPECT_EQ(second.killers[1], Set({2}));
  EXPECT_EQ(Play(state, {kRest, kRest, left}).killers[1], Set({2}));
  EXPECT_EQ(Play(state, {kRest, kRest, kRest, left}).burnt, Set({}));  // they are out
}

TEST(StepWatcher, KnowsNobodyBehindFlamesOlderThanItself) {
  const State state = Row("*1.........", "flame (0,0) life 2\n");
  const StepEvents events = Play(state, {{kStop, Action::kLeft, kStop, kStop}});
  EXPECT_EQ(events.burnt, Set({1}));
  EXPECT_EQ(events.killers[1], Set({}));
}

// Agents with many strong bombs and kicks, playing legal moves at random.
State WildStart(Rng& rng) {
  State state = GenerateStart(GameSettings(), {BoardGenerator::kOfficial, StartCorners::kPermuted},
                              rng.Split(rng.Next()));
  for (AgentState& agent : state.agents) {
    agent.ammo = 4;
    agent.blast_strength = 4;
    agent.can_kick = true;
  }
  return state;
}

JointAction RandomLegal(const State& state, Rng& rng) {
  JointAction actions{};
  for (AgentId id = 0; id < kAgentCount; ++id) {
    if (!state.agents[id].alive) continue;
    const ActionSet legal = LegalActions(state, id);
    do {
      actions[id] = static_cast<Action>(rng.Below(kActionCount));
    } while ((legal >> static_cast<int>(actions[id]) & 1) == 0);
  }
  return actions;
}

TEST(StepWatcher, FindsTheCauseOfEveryDeathOfRandomGames) {
  Rng rng(7);
  int deaths = 0;
  int kicks = 0;
  for (int game = 0; game < 200; ++game) {
    State state = WildStart(rng);
    StepWatcher watcher;
    while (!OutcomeOf(GameSettings(), state).done) {
      const State before = state;
      const JointAction actions = RandomLegal(state, rng);
      Step(GameSettings(), actions, state);
      const StepEvents events = watcher.Watch(GameSettings(), before, actions, state);
      kicks += std::popcount(events.kicked);
      for (AgentId id = 0; id < kAgentCount; ++id) {
        const bool died = before.agents[id].alive && !state.agents[id].alive;
        ASSERT_EQ((events.burnt >> id & 1) != 0, died);
        ASSERT_EQ(events.killers[id] != 0, died) << "game " << game << " step " << state.step;
        deaths += died ? 1 : 0;
      }
    }
  }
  EXPECT_GT(deaths, 400);
  EXPECT_GT(kicks, 100);
}

}  // namespace
}  // namespace powderkeg

#include "common/policies/policy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "common/pommerman/board_text.h"
#include "common/pommerman/generate.h"
#include "common/pommerman/step.h"

namespace powderkeg {
namespace {

using ::testing::Each;
using ::testing::Gt;

constexpr std::array<PolicyKind, 5> kKinds = {PolicyKind::kIdle, PolicyKind::kRandom,
                                              PolicyKind::kHarmless, PolicyKind::kSimpleUnbiased,
                                              PolicyKind::kOfficialSimple};

template <std::size_t size>
bool IsPermutation(std::array<std::uint8_t, size> order) {
  std::ranges::sort(order);
  for (std::size_t i = 0; i < size; ++i) {
    if (order[i] != i) return false;
  }
  return true;
}

// The actions of four equal agents, up to `steps` of one game.
std::vector<JointAction> PlayGame(PolicyKind kind, std::uint64_t seed, int steps) {
  const GameSettings settings;
  State state = GenerateStart(settings, {}, Rng(seed));
  Rng rng(seed + 1);
  std::array<PolicyTraits, kAgentCount> traits;
  std::array<PolicyMemory, kAgentCount> memories;
  for (PolicyTraits& trait : traits) trait = PolicyTraits::Draw(rng);
  std::vector<JointAction> game;
  for (int step = 0; step < steps && !OutcomeOf(settings, state).done; ++step) {
    JointAction actions{};
    for (AgentId id = 0; id < kAgentCount; ++id) {
      if (!state.agents[id].alive) continue;
      actions[id] = Decide(kind, {state, settings, id}, traits[id], memories[id], rng);
    }
    game.push_back(actions);
    Step(settings, actions, state);
  }
  return game;
}

TEST(PolicyTest, NamesAreReadBack) {
  for (const PolicyKind kind : kKinds) EXPECT_EQ(PolicyKindFor(NameOf(kind)), kind);
  EXPECT_EQ(PolicyKindFor("simple"), std::nullopt);
  EXPECT_EQ(PolicyKindFor(""), std::nullopt);
}

TEST(PolicyTest, TraitsAreUniformlyRandomOrders) {
  Rng rng(7);
  std::map<int, int> first_agents, last_rows, first_columns;
  for (int draw = 0; draw < 4000; ++draw) {
    const PolicyTraits traits = PolicyTraits::Draw(rng);
    ASSERT_TRUE(IsPermutation(traits.agent_order));
    ASSERT_TRUE(IsPermutation(traits.row_order));
    ASSERT_TRUE(IsPermutation(traits.column_order));
    ++first_agents[traits.agent_order.front()];
    ++last_rows[traits.row_order.back()];
    ++first_columns[traits.column_order.front()];
  }
  for (const auto& [agent, count] : first_agents) EXPECT_NEAR(count, 1000, 150) << agent;
  for (const auto& [row, count] : last_rows) EXPECT_NEAR(count, 364, 100) << row;
  for (const auto& [column, count] : first_columns) EXPECT_NEAR(count, 364, 100) << column;
}

TEST(PolicyTest, SameSeedPlaysTheSameGame) {
  for (const PolicyKind kind : kKinds) {
    EXPECT_EQ(PlayGame(kind, 5, 200), PlayGame(kind, 5, 200)) << NameOf(kind);
  }
  EXPECT_NE(PlayGame(PolicyKind::kSimpleUnbiased, 5, 200),
            PlayGame(PolicyKind::kSimpleUnbiased, 6, 200));
}

TEST(PolicyTest, IdleNeverMoves) {
  for (const JointAction& actions : PlayGame(PolicyKind::kIdle, 1, 50)) {
    EXPECT_THAT(actions, Each(Action::kStop));
  }
}

TEST(PolicyTest, RandomPlaysEveryAction) {
  const State state = GenerateStart({}, {}, Rng(1));
  PolicyMemory memory;
  Rng rng(3);
  std::array<int, kActionCount> counts{};
  for (int i = 0; i < 6000; ++i) {
    ++counts[static_cast<int>(
        Decide(PolicyKind::kRandom, {state, GameSettings(), 0}, {}, memory, rng))];
  }
  EXPECT_THAT(counts, Each(Gt(850)));
}

TEST(PolicyTest, HarmlessPlaysEveryLegalActionButBombs) {
  State state = GenerateStart({}, {}, Rng(1));
  state.wood.Add(state.agents[0].cell - 1);
  PolicyMemory memory;
  Rng rng(3);
  std::set<Action> played;
  for (int i = 0; i < 200; ++i) {
    played.insert(Decide(PolicyKind::kHarmless, {state, GameSettings(), 0}, {}, memory, rng));
  }
  EXPECT_EQ(played.contains(Action::kBomb), false);
  EXPECT_EQ(played.contains(Action::kLeft), false);
  for (int action = 0; action < kActionCount; ++action) {
    const bool legal = (LegalActions(state, 0) >> action & 1) != 0;
    if (static_cast<Action>(action) == Action::kBomb) continue;
    EXPECT_EQ(played.contains(static_cast<Action>(action)), legal) << action;
  }
}

TEST(PolicyTest, ObservedMovesAreRememberedAsDecided) {
  PolicyMemory memory;
  for (const Cell cell : {0, 1, 2, 13, 14}) {
    ObserveMove(PolicyKind::kSimpleUnbiased, 0, cell, memory);
  }
  EXPECT_EQ(memory.recent_count, 4);
  EXPECT_EQ(memory.recent[0], RememberedPosition(0, 1));
  EXPECT_EQ(memory.recent[3], RememberedPosition(1, 3));
  PolicyMemory unchanged;
  ObserveMove(PolicyKind::kRandom, 0, 1, unchanged);
  EXPECT_EQ(unchanged, PolicyMemory());
}

// Where no move is blocked, what was seen is what the agent remembers.
TEST(PolicyTest, ObservationFollowsTheMemoryOfAnUnblockedAgent) {
  const GameSettings settings;
  State state = GenerateStart(settings, {}, Rng(2));
  for (AgentId id = 1; id < kAgentCount; ++id) state.agents[id].alive = false;
  Rng rng(4);
  const PolicyTraits traits = PolicyTraits::Draw(rng);
  PolicyMemory decided, observed;
  for (int step = 0; step < 300 && state.agents[0].alive; ++step) {
    const Cell before = state.agents[0].cell;
    JointAction actions{};
    actions[0] = Decide(PolicyKind::kSimpleUnbiased, {state, settings, 0}, traits, decided, rng);
    Step(settings, actions, state);
    ObserveMove(PolicyKind::kSimpleUnbiased, before, state.agents[0].cell, observed);
    ASSERT_EQ(decided, observed) << ToText(state);
  }
}

// Shares of decisions before which the memory that was observed equals the true one.
struct ObservedShares {
  double by_move = 0;
  double by_step = 0;
};

ObservedShares ObserveGames(PolicyKind kind, int games) {
  const GameSettings settings;
  int decisions = 0, by_move = 0, by_step = 0;
  for (int game = 0; game < games; ++game) {
    Rng rng(static_cast<std::uint64_t>(game));
    State state = GenerateStart(settings, {}, rng.Split(0));
    std::array<PolicyTraits, kAgentCount> traits;
    for (PolicyTraits& drawn : traits) drawn = PolicyTraits::Draw(rng);
    std::array<PolicyMemory, kAgentCount> memories, moves, steps;
    while (!OutcomeOf(settings, state).done) {
      const State before = state;
      JointAction actions{};
      for (AgentId id = 0; id < kAgentCount; ++id) {
        if (!state.agents[id].alive) continue;
        ++decisions;
        by_move += moves[id] == memories[id];
        by_step += steps[id] == memories[id];
        actions[id] = Decide(kind, {before, settings, id}, traits[id], memories[id], rng);
      }
      Step(settings, actions, state);
      for (AgentId id = 0; id < kAgentCount; ++id) {
        if (!before.agents[id].alive) continue;
        ObserveMove(kind, before.agents[id].cell, state.agents[id].cell, moves[id]);
        ObserveStep(kind, {before, settings, id}, state, PolicyTraits(), steps[id], rng);
      }
    }
  }
  return {static_cast<double>(by_move) / decisions, static_cast<double>(by_step) / decisions};
}

TEST(PolicyTest, ObservingWithThePositionsFindsMostMemories) {
  const ObservedShares unbiased = ObserveGames(PolicyKind::kSimpleUnbiased, 20);
  EXPECT_GT(unbiased.by_step, unbiased.by_move + 0.05);
  EXPECT_GT(unbiased.by_step, 0.9);
  const ObservedShares official = ObserveGames(PolicyKind::kOfficialSimple, 20);
  EXPECT_GT(official.by_step, official.by_move + 0.5);
  EXPECT_GT(official.by_step, 0.7);
}

TEST(PolicyTest, WhatNoDecisionExplainsIsRememberedAsAMove) {
  State before = GenerateStart({}, {}, Rng(1));
  State after = before;
  after.agents[0].cell = static_cast<std::uint8_t>(before.agents[3].cell);
  PolicyMemory memory;
  Rng rng(1);
  ObserveStep(PolicyKind::kSimpleUnbiased, {before, GameSettings(), 0}, after, {}, memory, rng);
  EXPECT_EQ(memory.recent_count, 1);
  EXPECT_EQ(memory.recent[0], RememberedPosition(1, 9));
}

}  // namespace
}  // namespace powderkeg

#include "actors/search/model_choice.h"

#include <gtest/gtest.h>

#include "actors/search/order_inference.h"
#include "common/pommerman/step.h"
#include "tests/pommerman/board_reader.h"
#include "tests/search/search_support.h"

namespace powderkeg {
namespace {

// The policy that agent 1 is taken for after some steps of a game in which all play `kind`.
PolicyKind ChosenAgainst(PolicyKind kind, int steps, std::uint64_t seed) {
  const GameSettings game;
  Rng rng(seed);
  std::array<PolicyTraits, kAgentCount> traits;
  std::array<PolicyMemory, kAgentCount> memories;
  for (PolicyTraits& drawn : traits) drawn = PolicyTraits::Draw(rng);
  ModelChoice choice;
  choice.Start(ModelMemory::kSynchronized, Rng(seed + 1));
  State state = KnownStart(seed);
  for (int step = 0; step < steps && state.agents[1].alive; ++step) {
    JointAction actions{};
    for (std::size_t id = 0; id < kAgentCount; ++id) {
      if (!state.agents[id].alive) continue;
      const PolicyView view{state, game, static_cast<AgentId>(id)};
      actions[id] = Decide(kind, view, traits[id], memories[id], rng);
    }
    const State before = state;
    Step(game, actions, state);
    choice.Observe({before, game, 1}, traits[1], state);
  }
  return choice.best().policy;
}

TEST(ModelChoice, RecognisesEveryCandidate) {
  for (const PolicyKind kind :
       {PolicyKind::kSimpleUnbiased, PolicyKind::kOfficialSimple, PolicyKind::kIdle}) {
    int right = 0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) right += ChosenAgainst(kind, 60, seed) == kind;
    EXPECT_GE(right, 17) << NameOf(kind);
  }
}

TEST(ModelChoice, AssumesSimpleUnbiasedAtFirst) {
  ModelChoice choice;
  choice.Start(ModelMemory::kSynchronized, Rng(1));
  EXPECT_EQ(choice.best().policy, PolicyKind::kSimpleUnbiased);
}

TEST(ModelChoice, ResetMemoryStaysEmpty) {
  ModelChoice choice;
  choice.Start(ModelMemory::kReset, Rng(1));
  const State state = KnownStart(1);
  choice.Observe({state, GameSettings{}, 1}, PolicyTraits{}, state);
  EXPECT_EQ(choice.best().memory, PolicyMemory());
}

TEST(SeenAction, MovesAndBombsAreSeenAndTheRestIsNot) {
  State before = KnownStart(1);
  Action seen = Action::kStop;
  EXPECT_FALSE(SeenAction(before, before, 1, seen)) << "stopped or bounced";

  const Cell cell = before.agents[1].cell;
  State moved = before;
  moved.agents[1].cell = static_cast<std::uint8_t>(Neighbour(cell, Direction::kUp));
  ASSERT_TRUE(SeenAction(before, moved, 1, seen));
  EXPECT_EQ(seen, Action::kUp);

  State bombed = before;
  bombed.AddBomb({.cell = static_cast<std::uint8_t>(cell), .life = 9});
  ASSERT_TRUE(SeenAction(before, bombed, 1, seen));
  EXPECT_EQ(seen, Action::kBomb);
  EXPECT_FALSE(SeenAction(bombed, bombed, 1, seen)) << "the bomb lay there before";

  State reappeared = before;
  reappeared.agents[1].cell = static_cast<std::uint8_t>(CellAt(5, 5));
  EXPECT_FALSE(SeenAction(before, reappeared, 1, seen)) << "out of the fog";
}

TEST(OrderInference, FindsTheAgentThatIsApproached) {
  // Agent 0 may go for agent 1 (right) or agent 2 (down); it goes down.
  const State state = FromText(R"(
    0......1...
    .##########
    .##########
    .##########
    .##########
    .##########
    .##########
    2##########
    ###########
    ###########
    ###########
  )");
  const GameSettings game;
  const PolicyView view{state, game, 0};
  PolicyMemory memory;  // of two positions: not in a loop
  memory.recent_count = 2;
  for (const auto& [seen, target] : {std::pair{Action::kDown, 2}, std::pair{Action::kRight, 1}}) {
    OrderInference inference;
    inference.Start(PolicyTraits{}, Rng(1));
    inference.Observe(view, memory, seen);
    const auto& order = inference.traits().agent_order;
    const auto place = [&](int agent) { return std::find(order.begin(), order.end(), agent); };
    EXPECT_LT(place(target), place(3 - target));
  }
}

}  // namespace
}  // namespace powderkeg

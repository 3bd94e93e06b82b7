#include "actors/search/model_choice.h"

#include <gtest/gtest.h>

#include "actors/search/order_inference.h"
#include "common/pommerman/step.h"
#include "tests/pommerman/board_reader.h"
#include "tests/search/search_support.h"

namespace powderkeg {
namespace {

using Shares = std::array<std::uint8_t, kActionCount>;

// A game in which agent 1 is watched, and the others play SimpleUnbiased.
class Watched {
 public:
  Watched(std::uint64_t seed, bool with_prediction) : rng_(seed), state_(KnownStart(seed)) {
    for (PolicyTraits& drawn : traits_) drawn = PolicyTraits::Draw(rng_);
    choice.Start(ModelMemory::kSynchronized, with_prediction, Rng(seed + 1));
  }

  // Some steps of agent 1 by a policy; of it is foretold what a network without a clue says.
  void Play(PolicyKind kind, int steps) {
    for (int step = 0; step < steps && state_.agents[1].alive; ++step) {
      PlayStep(DecisionOf(1, kind), Shares{42, 42, 42, 42, 42, 42});
    }
  }
  // The same by what is foretold, which differs from step to step.
  void PlayAsForetold(int steps) {
    for (int step = 0; step < steps && state_.agents[1].alive; ++step) {
      Shares foretold{};
      foretold[rng_.Below(kActionCount)] = 150;
      foretold[rng_.Below(kActionCount)] = 100;
      PlayStep(DrawnAction(foretold, LegalActions(state_, 1), rng_), foretold);
    }
  }

  [[nodiscard]] bool lives() const { return state_.agents[1].alive; }

  ModelChoice choice;

 private:
  Action DecisionOf(AgentId agent, PolicyKind kind) {
    return Decide(kind, {state_, game_, agent}, traits_[agent], memories_[agent], rng_);
  }
  void PlayStep(Action action, const Shares& foretold) {
    JointAction actions{};
    for (AgentId id = 0; id < kAgentCount; ++id) {
      if (id != 1 && state_.agents[id].alive) {
        actions[id] = DecisionOf(id, PolicyKind::kSimpleUnbiased);
      }
    }
    actions[1] = action;
    const State before = state_;
    Step(game_, actions, state_);
    choice.Observe({before, game_, 1}, traits_[1], state_, foretold);
  }

  GameSettings game_;
  Rng rng_;
  State state_;
  std::array<PolicyTraits, kAgentCount> traits_;
  std::array<PolicyMemory, kAgentCount> memories_;
};

// In how many of 20 games the agent is taken for `kind`, and not for what is foretold.
template <typename Game>
int Recognised(PolicyKind kind, bool with_prediction, Game&& play) {
  int right = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Watched game(seed, with_prediction);
    play(game);
    right += !game.choice.prefers_prediction() && game.choice.best().policy == kind ? 1 : 0;
  }
  return right;
}

constexpr std::array kCandidates = {PolicyKind::kSimpleUnbiased, PolicyKind::kOfficialSimple,
                                    PolicyKind::kIdle};

TEST(ModelChoice, RecognisesEveryCandidate) {
  for (const PolicyKind kind : kCandidates) {
    for (const bool with_prediction : {false, true}) {
      const auto play = [&](Watched& game) { game.Play(kind, 60); };
      EXPECT_GE(Recognised(kind, with_prediction, play), 17) << NameOf(kind);
    }
  }
}

TEST(ModelChoice, NoticesAChangeOfMind) {
  for (const PolicyKind kind : kCandidates) {
    const PolicyKind before =
        kind == PolicyKind::kIdle ? PolicyKind::kSimpleUnbiased : PolicyKind::kIdle;
    int lived = 0;
    const auto play = [&](Watched& game) {
      game.Play(before, 20);
      game.Play(kind, 40);
      lived += game.lives() ? 1 : 0;
    };
    const int recognised = Recognised(kind, /*with_prediction=*/true, play);
    EXPECT_GE(lived, 5) << NameOf(kind);
    EXPECT_GE(recognised, 0.8 * lived) << NameOf(kind);
  }
}

TEST(ModelChoice, WhoDoesWhatIsForetoldIsPredicted) {
  int predicted = 0;
  int unasked = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Watched game(seed, /*with_prediction=*/true);
    game.PlayAsForetold(40);
    predicted += game.choice.prefers_prediction() ? 1 : 0;
    Watched other(seed, /*with_prediction=*/false);
    other.PlayAsForetold(40);
    unasked += other.choice.prefers_prediction() ? 1 : 0;
  }
  EXPECT_GE(predicted, 18);
  EXPECT_EQ(unasked, 0);
}

TEST(ModelChoice, NothingIsJudgedByAStepOfWhichNothingWasForetold) {
  ModelChoice choice;
  choice.Start(ModelMemory::kSynchronized, /*with_prediction=*/true, Rng(1));
  const double before = choice.best().evidence;
  const State state = KnownStart(1);
  choice.Observe({state, GameSettings{}, 1}, PolicyTraits{}, state, Shares{});
  EXPECT_EQ(choice.best().evidence, before);
  EXPECT_NE(choice.best().memory, PolicyMemory()) << "but it is remembered";
}

TEST(ModelChoice, EvidenceIsFiniteHoweverSure) {
  ModelChoice choice;
  choice.Start(ModelMemory::kSynchronized, /*with_prediction=*/true, Rng(1));
  const State state = KnownStart(1);
  for (int step = 0; step < 2000; ++step) {
    choice.Observe({state, GameSettings{}, 1}, PolicyTraits{}, state, Shares{0, 0, 0, 0, 0, 255});
  }
  EXPECT_EQ(choice.best().policy, PolicyKind::kIdle);
  EXPECT_FALSE(choice.prefers_prediction());
  EXPECT_GT(choice.best().evidence, -1000);
}

TEST(ModelChoice, AssumesSimpleUnbiasedAtFirst) {
  ModelChoice choice;
  choice.Start(ModelMemory::kSynchronized, /*with_prediction=*/false, Rng(1));
  EXPECT_EQ(choice.best().policy, PolicyKind::kSimpleUnbiased);
}

TEST(ModelChoice, ResetMemoryStaysEmpty) {
  ModelChoice choice;
  choice.Start(ModelMemory::kReset, /*with_prediction=*/false, Rng(1));
  const State state = KnownStart(1);
  choice.Observe({state, GameSettings{}, 1}, PolicyTraits{}, state, Shares{});
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

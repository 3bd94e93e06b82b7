#include "actors/search/order_inference.h"

#include <gtest/gtest.h>

#include "common/pommerman/step.h"
#include "tests/search/search_support.h"

namespace powderkeg {
namespace {

// Four SimpleUnbiased agents play; calls visit(agent, view, memory, action, after, traits) for
// each of their decisions, until `games` games are over.
template <typename Visit>
void PlayGames(std::uint64_t first_seed, int games, const GameSettings& game, Visit&& visit) {
  for (std::uint64_t seed = first_seed; seed < first_seed + static_cast<std::uint64_t>(games);
       ++seed) {
    State state = KnownStart(seed);
    std::array<PolicyTraits, kAgentCount> traits;
    std::array<PolicyMemory, kAgentCount> memories;
    Rng rng(seed);
    for (PolicyTraits& drawn : traits) drawn = PolicyTraits::Draw(rng);
    for (Outcome outcome; !outcome.done;) {
      const State before = state;
      const auto remembered = memories;
      JointAction actions{};
      for (std::size_t id = 0; id < kAgentCount; ++id) {
        if (!state.agents[id].alive) continue;
        actions[id] = Decide(PolicyKind::kSimpleUnbiased, {before, game, static_cast<AgentId>(id)},
                             traits[id], memories[id], rng);
      }
      outcome = Advance(game, actions, state);
      for (std::size_t id = 0; id < kAgentCount; ++id) {
        if (!before.agents[id].alive) continue;
        const PolicyView view{before, game, static_cast<AgentId>(id)};
        visit(view, remembered[id], actions[id], state, traits[id]);
      }
    }
  }
}

bool IsDrawn(const PolicyView& view, const PolicyTraits& traits, PolicyMemory memory) {
  Rng rng(1);
  static_cast<void>(Decide(PolicyKind::kSimpleUnbiased, view, traits, memory, rng));
  return !(rng == Rng(1));
}

TEST(Escape, ChoosesAsThePolicyForAnyOrders) {
  Rng rng(3);
  int choices = 0;
  int none = 0;
  PlayGames(
      1, 12, {},
      [&](const PolicyView& view, PolicyMemory memory, Action, const State&, const PolicyTraits&) {
        const Escape escape(view);
        if (!escape.in_danger()) return;
        for (int i = 0; i < 4; ++i) {
          const PolicyTraits orders = PolicyTraits::Draw(rng);
          const Direction move = escape.Choose(orders);
          if (move == Direction::kNone) {
            // On to the rules for items and for wandering, which draws unless it has no choice.
            const Action action = Decide(PolicyKind::kSimpleUnbiased, view, orders, memory, rng);
            EXPECT_TRUE(IsDrawn(view, orders, memory) || action == Action::kStop ||
                        view.state.VisibleItems().Any());
            ++none;
            continue;
          }
          EXPECT_TRUE(escape.possible());
          EXPECT_FALSE(IsDrawn(view, orders, memory));
          PolicyMemory forgotten = memory;
          EXPECT_EQ(Decide(PolicyKind::kSimpleUnbiased, view, orders, forgotten, rng),
                    ActionOf(move));
          ++choices;
        }
      });
  EXPECT_GT(choices, 2000);
  EXPECT_GT(none, 200);
}

TEST(Escape, WithoutDangerThereIsNone) {
  const State state = KnownStart(1);
  const Escape escape({state, {}, 0});
  EXPECT_FALSE(escape.in_danger());
  EXPECT_FALSE(escape.possible());
  EXPECT_EQ(escape.Choose(PolicyTraits()), Direction::kNone);
}

TEST(Escape, SeesNoBombInTheFog) {
  State state = KnownStart(1);
  const Cell cell = state.agents[0].cell;
  state.AddBomb({.cell = static_cast<std::uint8_t>(cell), .life = 5});
  EXPECT_TRUE(Escape({state, {}, 0}).in_danger());
  EXPECT_FALSE(Escape({state, {}, 0, ~BitBoard::Of(cell)}).in_danger());
}

// One agent escapes again and again: its decisions in generated positions, in the order of play.
struct Escapes {
  std::vector<State> states;
  std::vector<PolicyMemory> memories;
};

Escapes GenerateEscapes(std::size_t count) {
  Escapes escapes;
  PlayGames(50, 20, {},
            [&](const PolicyView& view, const PolicyMemory& memory, Action, const State&,
                const PolicyTraits&) {
              if (view.self != 0 || escapes.states.size() == count || !Escape(view).possible())
                return;
              escapes.states.push_back(view.state);
              escapes.memories.push_back(memory);
            });
  return escapes;
}

// The moves of an agent with these orders; kStop where its scan leads nowhere.
std::vector<Action> MovesOf(const Escapes& escapes, const PolicyTraits& traits) {
  std::vector<Action> actions;
  for (const State& state : escapes.states) {
    actions.push_back(ActionOf(Escape({state, {}, 0}).Choose(traits)));
  }
  return actions;
}

class KnownOrders : public testing::Test {
 protected:
  KnownOrders() : escapes_(GenerateEscapes(300)) {}

  void Learn(std::size_t first, std::size_t end, OrderInference& orders) const {
    for (std::size_t i = first; i < end; ++i) {
      if (actions_[i] == Action::kStop) continue;
      orders.Observe({escapes_.states[i], game_, 0}, escapes_.memories[i], actions_[i]);
    }
  }
  // The share of the escapes [first, end) foretold, those without a move included; settles before
  // each if asked.
  double Foretold(std::size_t first, std::size_t end, bool settles, OrderInference orders) const {
    int right = 0;
    for (std::size_t i = first; i < end; ++i) {
      const PolicyView view{escapes_.states[i], game_, 0};
      if (settles) orders.Settle(view);
      right += ActionOf(Escape(view).Choose(orders.traits())) == actions_[i] ? 1 : 0;
    }
    return right / static_cast<double>(end - first);
  }
  OrderInference Start(std::uint64_t seed) {
    Rng rng(seed);
    actions_ = MovesOf(escapes_, PolicyTraits::Draw(rng));
    OrderInference orders;
    orders.Start(PolicyTraits::Draw(rng), rng);
    return orders;
  }

  GameSettings game_;
  Escapes escapes_;
  std::vector<Action> actions_;
};

TEST_F(KnownOrders, AreForetoldAfterSomeEscapes) {
  double before = 0;
  double after = 0;
  constexpr int kAgents = 20;
  for (std::uint64_t seed = 1; seed <= kAgents; ++seed) {
    OrderInference orders = Start(seed);
    before += Foretold(100, 300, true, orders) / kAgents;
    Learn(0, 100, orders);
    after += Foretold(100, 300, true, orders) / kAgents;
  }
  EXPECT_LT(before, 0.70);
  EXPECT_GT(after, 0.87);
}

TEST_F(KnownOrders, TheMajorityForetellsMoreThanOneGuess) {
  double one = 0;
  double majority = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    OrderInference orders = Start(seed);
    Learn(0, 40, orders);
    one += Foretold(40, 300, false, orders);
    majority += Foretold(40, 300, true, orders);
  }
  EXPECT_GT(majority, one + 20 * 0.02);
}

TEST_F(KnownOrders, ExplainWhatWasSeen) {
  double share = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    OrderInference orders = Start(seed);
    Learn(0, 40, orders);
    orders.Settle({escapes_.states[39], game_, 0});
    share += Foretold(0, 40, false, orders) / 20;
  }
  EXPECT_GT(share, 0.9);
}

TEST_F(KnownOrders, LearningIsDeterministicAndAValue) {
  OrderInference orders = Start(1);
  OrderInference same = Start(1);
  Learn(0, 60, orders);
  Learn(0, 60, same);
  const PolicyView view{escapes_.states[60], game_, 0};
  orders.Settle(view);
  same.Settle(view);
  EXPECT_EQ(orders.traits(), same.traits());

  OrderInference copy = orders;
  Learn(60, 200, orders);
  EXPECT_EQ(copy.traits(), same.traits());
  Learn(60, 200, copy);
  orders.Settle(view);
  copy.Settle(view);
  EXPECT_EQ(copy.traits(), orders.traits());
}

TEST_F(KnownOrders, AreForgottenAtTheNextStart) {
  OrderInference orders = Start(1);
  const OrderInference fresh = orders;
  Learn(0, 200, orders);
  orders = Start(1);
  EXPECT_EQ(Foretold(0, 300, true, orders), Foretold(0, 300, true, fresh));
}

TEST(OrderInference, FindsTheOrderOfAgents) {
  // The share of decisions about approaching that are foretold once 100 steps are played.
  const GameSettings game;
  std::array<OrderInference, kAgentCount> orders;
  int right = 0;
  int all = 0;
  PlayGames(
      80, 30, game,
      [&](const PolicyView& view, const PolicyMemory& memory, Action action, const State& after,
          const PolicyTraits& traits) {
        OrderInference& inference = orders[static_cast<std::size_t>(view.self)];
        if (view.state.step == 0) {
          Rng rng(static_cast<std::uint64_t>(view.self));
          inference.Start(PolicyTraits::Draw(rng), rng);
        }
        if (view.state.step >= 100 && !Escape(view).in_danger() && !IsDrawn(view, traits, memory)) {
          PolicyMemory remembered = memory;
          Rng rng(1);
          right += Decide(PolicyKind::kSimpleUnbiased, view, inference.traits(), remembered, rng) ==
                   action;
          ++all;
        }
        Action seen = Action::kStop;
        if (SeenAction(view.state, after, view.self, seen)) inference.Observe(view, memory, seen);
      });
  EXPECT_GT(all, 1000);
  EXPECT_GT(right, all * 98 / 100);
}

}  // namespace
}  // namespace powderkeg

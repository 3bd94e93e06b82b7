// What the tree holds when several leaves of it wait for their evaluations at the same time.

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <string>
#include <tuple>

#include "tests/pommerman/board_reader.h"
#include "tests/search/hash_evaluator.h"
#include "tests/search/known_answers.h"
#include "tests/search/search_support.h"
#include "tests/search/settings_from_text.h"

namespace powderkeg {
namespace {

// Simulations and the sum of the values that they ended with.
struct Ended {
  std::uint32_t count = 0;
  double sum = 0;
};

// Those through an edge, counted from the leaves: a node that goes on was the leaf of one (of none
// where it is a ply that asked nothing), a terminal node of all that reached it. Checks every edge
// on the way.
Ended ThroughEdge(const Tree& tree, const Node& node, std::size_t action, bool plies_ask) {
  const std::uint32_t visits = node.visits[action];
  if (node.child[action] == kNoNode) {
    EXPECT_EQ(visits, 0U);
    return {};
  }
  const Node& child = tree[node.child[action]];
  const auto own = static_cast<double>(child.evaluation);
  if (child.stage == Node::Stage::kTerminal) {
    EXPECT_NEAR(node.value[action], own, 1e-4);
    return {visits, visits * own};
  }
  Ended ended = child.side > 0 || plies_ask ? Ended{1, own} : Ended{};
  std::uint32_t below = 0;
  for (std::size_t a = 0; a < kActionCount; ++a) {
    const Ended more = ThroughEdge(tree, child, a, plies_ask);
    ended.count += more.count;
    ended.sum += more.sum;
    below += child.visits[a];
  }
  EXPECT_EQ(child.visit_count, below);
  EXPECT_EQ(visits, ended.count);
  EXPECT_NEAR(node.value[action], ended.sum / ended.count, 1e-4) << visits << " visits";
  return ended;
}

class LeavesInFlight : public testing::TestWithParam<std::tuple<std::string, int>> {
 protected:
  LeavesInFlight() : settings_(ParseSearchSettings(std::get<0>(GetParam()))) {
    settings_.simulations = 150;
    settings_.leaves_per_batch = std::get<1>(GetParam());
  }

  // Finishes the search; looks at the whole tree whenever all answers are there.
  static SearchResult FinishAndCheck(Search& search) {
    const bool plies_ask = !Predicts(search.settings());
    HashEvaluator evaluator;
    EvaluationBatch batch;
    while (search.Gather(batch) && !testing::Test::HasFailure()) {
      evaluator.Evaluate({}, batch.positions(), batch.AllocateEvaluations());
      search.Scatter(batch);
      batch.Clear();
      for (std::size_t a = 0; a < kActionCount; ++a) {
        ThroughEdge(search.tree(), search.tree()[0], a, plies_ask);
      }
    }
    return search.Result();
  }

  SearchSettings settings_;
};

// Whatever was under way beside it, every simulation weighs the same.
TEST_P(LeavesInFlight, LeaveThePlainMeanOnEveryEdge) {
  for (const State& start : {KnownStart(1), KnownStart(2), FromText(kEscape), FromText(kKill)}) {
    Search search(settings_, {});
    const OpponentModels models = ModelsAtStart(settings_, 0);
    State state = start;
    for (std::uint64_t move = 0; move < 3 && state.agents[0].alive; ++move) {
      search.Start(state, models, Rng(move));
      const SearchResult result = FinishAndCheck(search);
      ASSERT_FALSE(HasFailure()) << "move " << move;
      JointAction actions = result.expected_actions;
      actions[0] = result.best;
      Advance({}, actions, state);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Search, LeavesInFlight,
    testing::Combine(testing::Values("", "tree=two_player", "root=gumbel,tree=two_player",
                                     "opponents=raw_network", "exploratory_start=0.3",
                                     "opponents=predicted,tree=two_player",
                                     "opponents=predicted,tree=two_player,root=gumbel"),
                     testing::Values(1, 4, 8, 32)),
    [](const auto& test) {
      std::string name = std::get<0>(test.param);
      std::ranges::replace_if(
          name, [](char c) { return std::isalnum(c) == 0; }, '_');
      return (name.empty() ? "Default" : name) + "_" + std::to_string(std::get<1>(test.param));
    });

}  // namespace
}  // namespace powderkeg

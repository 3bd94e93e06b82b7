#include "actors/search/tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "common/base/rng.h"

namespace powderkeg {
namespace {

constexpr std::array<float, kActionCount> kPolicy = {0.1F, 0.3F, 0.2F, 0.2F, 0.15F, 0.05F};
constexpr ActionSet kAll = 0b111111;

// A tree whose root has edges.
Tree TreeWithRoot(const SearchSettings& settings, ActionSet legal, std::int8_t side = 1) {
  Tree tree(settings);
  tree.Clear(100);
  Node& root = tree[tree.Add(kNoNode, Action::kStop)];
  root.side = side;
  tree.SetEdges(root, legal, kPolicy);
  return tree;
}

void Simulate(Tree& tree, NodeIndex node, Action action, float value) {
  tree.Visit(node, action);
  NodeIndex child = tree[node].child[static_cast<std::size_t>(action)];
  if (child == kNoNode) {
    child = tree.Add(node, action);
    tree[child].side = 1;
    tree.SetEdges(tree[child], kAll, kPolicy);
  }
  tree.BackUp(child, value);
}

// The formula of tree.h, written out.
Action Expected(const SearchSettings& settings, const Node& node) {
  double n = 0;
  for (const std::uint32_t visits : node.visits) n += visits;
  const double c =
      settings.c_puct_init + std::log((n + settings.c_puct_base + 1) / settings.c_puct_base);
  int best = -1;
  double best_score = 0;
  for (int action = 0; action < kActionCount; ++action) {
    const auto a = static_cast<std::size_t>(action);
    if ((node.legal >> action & 1) == 0) continue;
    const double q = node.side * static_cast<double>(node.value[a]);
    const double score =
        q + c * node.prior[a] * std::sqrt(std::max(n, 1.0)) / (1.0 + node.visits[a]);
    if (best < 0 || score > best_score + 1e-6) {
      best = action;
      best_score = score;
    }
  }
  return static_cast<Action>(best);
}

TEST(Tree, SelectsByTheFormula) {
  const SearchSettings settings = WithoutAids({});
  for (const std::int8_t side : {std::int8_t{1}, std::int8_t{-1}}) {
    Tree tree = TreeWithRoot(settings, kAll, side);
    Rng rng(5);
    for (int i = 0; i < 90; ++i) {
      const Action action = tree.Select(tree[0]);
      ASSERT_EQ(action, Expected(settings, tree[0])) << "simulation " << i;
      Simulate(tree, 0, action, static_cast<float>(2 * rng.Uniform() - 1));
    }
  }
}

TEST(Tree, FirstChoiceFollowsThePrior) {
  const Tree tree = TreeWithRoot(WithoutAids({}), kAll);
  EXPECT_EQ(tree.Select(tree[0]), Action::kUp);
}

TEST(Tree, TiesGoToTheLowestAction) {
  Tree tree = TreeWithRoot(WithoutAids({}), kAll);
  constexpr std::array<float, kActionCount> kEven = {0, 0.25F, 0.25F, 0.25F, 0.25F, 0};
  tree.SetEdges(tree[0], kAll, kEven);
  EXPECT_EQ(tree.Select(tree[0]), Action::kUp);
}

TEST(Tree, IllegalActionsAreNeverSelected) {
  for (const std::int8_t side : {std::int8_t{1}, std::int8_t{-1}}) {
    Tree tree = TreeWithRoot(WithoutAids({}), 0b100001, side);
    for (int i = 0; i < 50; ++i) {
      const Action action = tree.Select(tree[0]);
      ASSERT_TRUE(action == Action::kStop || action == Action::kBomb);
      Simulate(tree, 0, action, static_cast<float>(-side));
    }
    EXPECT_EQ(tree[0].prior[1], 0);
  }
}

TEST(Tree, RenormalisesPriorsWhereAsked) {
  SearchSettings settings = WithoutAids({});
  settings.renormalise_priors = true;
  const Tree tree = TreeWithRoot(settings, 0b000011);
  EXPECT_FLOAT_EQ(tree[0].prior[0], 0.25F);
  EXPECT_FLOAT_EQ(tree[0].prior[1], 0.75F);
}

TEST(Tree, FlattensAndSharpensPriorsByTemperature) {
  SearchSettings settings = WithoutAids({});
  settings.policy_temperature = 2;
  const Tree flat = TreeWithRoot(settings, kAll);
  EXPECT_NEAR(std::accumulate(flat[0].prior.begin(), flat[0].prior.end(), 0.0F), 1, 1e-6);
  EXPECT_NEAR(flat[0].prior[1] / flat[0].prior[0], std::sqrt(3), 1e-6);
  settings.policy_temperature = 0.01;
  const Tree sharp = TreeWithRoot(settings, kAll);
  EXPECT_FLOAT_EQ(sharp[0].prior[1], 1);
  EXPECT_EQ(sharp[0].prior[0], 0);
}

TEST(Tree, BackUpAveragesAlongThePath) {
  Tree tree = TreeWithRoot(WithoutAids({}), kAll);
  Simulate(tree, 0, Action::kUp, 0.5F);
  const NodeIndex child = tree[0].child[1];
  for (const float value : {-1.0F, 1.0F, 1.0F}) {
    tree.Visit(0, Action::kUp);
    Simulate(tree, child, Action::kLeft, value);
  }
  EXPECT_EQ(tree[0].visits[1], 4U);
  EXPECT_FLOAT_EQ(tree[0].value[1], 0.375F);
  EXPECT_EQ(tree[child].visits[3], 3U);
  EXPECT_FLOAT_EQ(tree[child].value[3], 1 / 3.0F);
}

// A simulation weighs in an edge's value when it ends, not before.
TEST(Tree, BackUpAveragesWhatHasEnded) {
  Tree tree = TreeWithRoot(WithoutAids({}), kAll);
  Simulate(tree, 0, Action::kUp, 0.5F);
  const NodeIndex child = tree[0].child[1];
  for (const Action action : {Action::kStop, Action::kLeft, Action::kRight}) {
    tree.Visit(0, Action::kUp);
    tree.Visit(child, action);
  }
  const NodeIndex stop = tree.Add(child, Action::kStop);
  const NodeIndex left = tree.Add(child, Action::kLeft);
  const NodeIndex right = tree.Add(child, Action::kRight);
  EXPECT_EQ(tree[0].visits[1], 4U) << "those under way count at once";
  EXPECT_FLOAT_EQ(tree[0].value[1], 0.5F);
  tree.BackUp(left, -1);
  EXPECT_FLOAT_EQ(tree[0].value[1], -0.25F);
  tree.Undo(right);
  EXPECT_EQ(tree[0].visits[1], 3U);
  tree.BackUp(stop, 1);
  EXPECT_FLOAT_EQ(tree[0].value[1], 0.5F / 3);
  EXPECT_EQ(tree[0].visits[1], 3U);
}

// Choosing among the visited actions and the next two unvisited by prior, as the predecessor does,
// is choosing among all.
TEST(Tree, ChoosesAmongVisitedAndTheNextTwo) {
  const SearchSettings settings = WithoutAids({});
  Rng rng(8);
  for (int game = 0; game < 200; ++game) {
    Tree tree = TreeWithRoot(settings, kAll, game % 2 == 0 ? std::int8_t{1} : std::int8_t{-1});
    std::array<float, kActionCount> policy;
    for (float& share : policy) share = static_cast<float>(1 + rng.Below(4)) / 24;  // often equal
    tree.SetEdges(tree[0], kAll, policy);
    for (int i = 0; i < 30; ++i) {
      const Action action = tree.Select(tree[0]);
      const auto& visits = tree[0].visits;
      int likelier = 0;  // unvisited actions before this one
      for (std::size_t a = 0; a < kActionCount; ++a) {
        const auto chosen = static_cast<std::size_t>(action);
        const bool before =
            policy[a] > policy[chosen] || (policy[a] == policy[chosen] && a < chosen);
        if (visits[a] == 0 && before) ++likelier;
      }
      ASSERT_TRUE(visits[static_cast<std::size_t>(action)] > 0 || likelier == 0);
      Simulate(tree, 0, action, static_cast<float>(2 * rng.Uniform() - 1));
    }
  }
}

// Adds a proven end, by default worth 1 or -1.
void EndWith(Tree& tree, NodeIndex parent, Action action, std::int8_t proven, float value) {
  tree.Visit(parent, action);
  const NodeIndex child = tree.Add(parent, action);
  tree[child].side = 1;
  tree[child].proven = proven;
  tree[child].evaluation = value;
  tree.BackUp(child, value);
  tree.Prove(child);
}
void EndWith(Tree& tree, NodeIndex parent, Action action, std::int8_t proven) {
  EndWith(tree, parent, action, proven, proven);
}

TEST(Tree, LostActionsAreClosed) {
  Tree tree = TreeWithRoot(WithoutAids({}), 0b000011);
  EndWith(tree, 0, Action::kUp, -1);
  EXPECT_EQ(tree[0].closed, 0b000010);
  EXPECT_EQ(tree[0].proven, 0);
  for (int i = 0; i < 20; ++i) {
    ASSERT_EQ(tree.Select(tree[0]), Action::kStop);
    Simulate(tree, 0, Action::kStop, -1);
  }
  Tree::SetPriors(tree[0], kPolicy);
  EXPECT_EQ(tree.Select(tree[0]), Action::kStop) << "new priors do not open it";
  tree.Visit(0, Action::kUp);
  tree.Undo(tree[0].child[1]);
  EXPECT_EQ(tree.Select(tree[0]), Action::kStop);
}

TEST(Tree, PositionsAreLostWhereEveryActionIs) {
  Tree tree = TreeWithRoot(WithoutAids({}), kAll);
  Simulate(tree, 0, Action::kUp, 0);
  const NodeIndex child = tree[0].child[1];
  tree.SetEdges(tree[child], 0b000101, kPolicy);
  EndWith(tree, child, Action::kStop, -1);
  EXPECT_EQ(tree[0].closed, 0);
  EndWith(tree, child, Action::kDown, -1);
  EXPECT_EQ(tree[child].proven, -1);
  EXPECT_EQ(tree[0].closed, 0b000010);
  EXPECT_EQ(tree[0].proven, 0);
}

TEST(Tree, OneWinningActionWins) {
  Tree tree = TreeWithRoot(WithoutAids({}), kAll);
  Simulate(tree, 0, Action::kUp, 0);
  EndWith(tree, tree[0].child[1], Action::kBomb, 1);
  EXPECT_EQ(tree[0].proven, 1);
  EXPECT_EQ(tree[0].closed, 0);
  EXPECT_FLOAT_EQ(tree[0].value[1], 1);
}

TEST(Tree, AnEnemyEscapesWhereItCan) {
  Tree tree = TreeWithRoot(WithoutAids({}), 0b000010);
  Simulate(tree, 0, Action::kUp, 0);
  const NodeIndex enemy = tree[0].child[1];
  tree[enemy].side = -1;
  tree.SetEdges(tree[enemy], 0b000011, kPolicy);
  EndWith(tree, enemy, Action::kStop, 1);
  EXPECT_EQ(tree[enemy].closed, 0b000001) << "the enemy does not step into it";
  EXPECT_EQ(tree[0].proven, 0);
  EndWith(tree, enemy, Action::kUp, 1);
  EXPECT_EQ(tree[0].proven, 1);
}

TEST(Tree, AProvenWinIsWorthWhatItsEndIs) {
  Tree tree = TreeWithRoot(WithoutAids({}), 0b000010);
  Simulate(tree, 0, Action::kUp, 0);
  const NodeIndex enemy = tree[0].child[1];
  tree[enemy].side = -1;
  tree.SetEdges(tree[enemy], 0b000011, kPolicy);
  EndWith(tree, enemy, Action::kStop, 1, 0.75F);
  EndWith(tree, enemy, Action::kUp, 1, 0.25F);
  EXPECT_EQ(tree[0].proven, 1);
  EXPECT_EQ(tree[0].value[1], 0.25F) << "the enemy puts it off";
}

TEST(Tree, UndoTakesVisitsBack) {
  Tree tree = TreeWithRoot(WithoutAids({}), kAll);
  Simulate(tree, 0, Action::kUp, 0.5F);
  const Node before = tree[0];
  tree.Visit(0, Action::kUp);
  tree.Undo(before.child[1]);
  EXPECT_EQ(tree[0].visits, before.visits);
  EXPECT_EQ(tree[0].urge, before.urge);
  EXPECT_EQ(tree[0].visit_count, before.visit_count);
}

TEST(Tree, KeepMakesASubtreeTheTree) {
  Tree tree = TreeWithRoot(WithoutAids({}), kAll);
  Simulate(tree, 0, Action::kStop, 0);
  Simulate(tree, 0, Action::kUp, 0);
  const NodeIndex kept = tree[0].child[1];
  Simulate(tree, tree[0].child[0], Action::kUp, 0);
  Simulate(tree, kept, Action::kBomb, 0.25F);
  Simulate(tree, kept, Action::kLeft, -0.25F);
  Simulate(tree, tree[kept].child[3], Action::kRight, 0.75F);

  tree.Keep(kept, 10);

  ASSERT_EQ(tree.size(), 4);
  EXPECT_EQ(tree[0].parent, kNoNode);
  EXPECT_EQ(tree[0].visit_count, 2U);
  const NodeIndex bomb = tree[0].child[5];
  const NodeIndex left = tree[0].child[3];
  EXPECT_EQ(tree[bomb].parent, 0);
  EXPECT_EQ(tree[left].parent, 0);
  EXPECT_EQ(tree[tree[left].child[4]].parent, left);
  EXPECT_FLOAT_EQ(tree[left].value[4], 0.75F);
}

}  // namespace
}  // namespace powderkeg

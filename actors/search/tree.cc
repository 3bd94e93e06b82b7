#include "actors/search/tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "actors/search/portable_math.h"
#include "common/base/check.h"
#include "common/config/tree_memory.h"

namespace powderkeg {
namespace {

// Requires that the edge is legal.
void RenewUrge(Node& node, std::size_t action) {
  const bool closed = Has(node.closed, action);
  node.urge[action] = closed ? -std::numeric_limits<float>::infinity()
                             : node.prior[action] / static_cast<float>(1 + node.visits[action]);
}

// Of the action that the mover would choose.
float BestValue(const Node& node) {
  const auto values = std::span(node.value).first<kActionCount>();
  return node.side > 0 ? std::ranges::max(values) : std::ranges::min(values);
}

// P^(1 / temperature), of sum 1.
std::array<float, kActionCount> Tempered(std::span<const float, kActionCount> policy,
                                         double temperature) {
  std::array<float, kActionCount> tempered{};
  const float highest = std::ranges::max(policy);
  float total = 0;
  for (std::size_t a = 0; a < kActionCount; ++a) {
    if (policy[a] <= 0) continue;
    const double logarithm = Log(static_cast<double>(policy[a] / highest)) / temperature;
    tempered[a] = static_cast<float>(ExpOfNegative(logarithm));
    total += tempered[a];
  }
  for (float& probability : tempered) probability /= total;
  return tempered;
}

}  // namespace

Tree::Tree(const SearchSettings& settings)
    : unvisited_value_(static_cast<float>(settings.unvisited_value)),
      renormalise_priors_(settings.renormalise_priors),
      policy_temperature_(settings.policy_temperature),
      enemies_choose_(settings.simulated_moves == SimulatedMoves::kAgainstSelf),
      c_puct_init_(settings.c_puct_init),
      c_puct_base_(settings.c_puct_base) {}

void Tree::Reserve(std::size_t nodes, std::size_t visits) {
  static_assert(sizeof nodes_[0] + sizeof under_way_[0] + sizeof foretold_[0] +
                    sizeof exploration_[0] ==
                kTreeNodeBytes);
  if (nodes_.size() < nodes) {
    nodes_.resize(nodes);
    under_way_.resize(nodes);
    foretold_.resize(nodes);
  }
  while (exploration_.size() <= visits) {
    const auto n = static_cast<double>(exploration_.size());
    const double c = c_puct_init_ + LogOnePlus((n + 1) / c_puct_base_);
    exploration_.push_back(static_cast<float>(c * std::sqrt(std::max(n, 1.0))));
  }
}

void Tree::Clear(int capacity) {
  size_ = 0;
  Reserve(static_cast<std::size_t>(capacity), static_cast<std::size_t>(capacity));
}

void Tree::Keep(NodeIndex node, int more) {
  moved_to_.assign(static_cast<std::size_t>(size_), kNoNode);
  NodeIndex kept = 0;
  for (NodeIndex old = node; old < size_; ++old) {
    const NodeIndex parent = old == node ? kNoNode : (*this)[old].parent;
    const NodeIndex new_parent =
        parent == kNoNode ? kNoNode : moved_to_[static_cast<std::size_t>(parent)];
    if (old != node && new_parent == kNoNode) continue;
    Node& moved = (*this)[kept];
    if (old != kept) {
      moved = (*this)[old];
      foretold(kept) = foretold(old);
    }
    moved.parent = new_parent;
    if (new_parent != kNoNode) {
      (*this)[new_parent].child[static_cast<std::size_t>(moved.parent_action)] = kept;
    }
    moved_to_[static_cast<std::size_t>(old)] = kept++;
  }
  size_ = kept;
  Reserve(static_cast<std::size_t>(kept + more),
          (*this)[0].visit_count + static_cast<std::size_t>(more));
}

NodeIndex Tree::Add(NodeIndex parent, Action parent_action) {
  DCHECK(static_cast<std::size_t>(size_) < nodes_.size());
  Node& node = (*this)[size_];
  node.parent = parent;
  node.parent_action = parent_action;
  node.stage = Node::Stage::kNew;
  node.proven = 0;
  node.visit_count = 0;
  if (parent != kNoNode) (*this)[parent].child[static_cast<std::size_t>(parent_action)] = size_;
  return size_++;
}

void Tree::SetEdges(Node& node, ActionSet legal,
                    std::span<const float, kActionCount> policy) const {
  std::array<float, kActionCount> tempered;
  if (policy_temperature_ != 1) {
    tempered = Tempered(policy, policy_temperature_);
    policy = tempered;
  }
  node.legal = legal;
  node.closed = 0;
  node.child.fill(kNoNode);
  node.visits.fill(0);
  node.visit_count = 0;
  const auto side = static_cast<float>(node.side);
  node.value.fill(-side * std::numeric_limits<float>::infinity());
  float total = 0;
  for (std::size_t a = 0; a < kActionCount; ++a) {
    const bool is_legal = Has(legal, a);
    node.prior[a] = is_legal ? policy[a] : 0;
    if (is_legal) node.value[a] = side * unvisited_value_;
    total += node.prior[a];
  }
  if (renormalise_priors_ && total > 0) {
    for (float& prior : node.prior) prior /= total;
  }
  node.urge.fill(0);
  std::ranges::copy(node.prior, node.urge.begin());
}

void Tree::SetPriors(Node& node, std::span<const float, kActionCount> priors) {
  for (std::size_t a = 0; a < kActionCount; ++a) {
    if (!Has(node.legal, a)) continue;
    node.prior[a] = priors[a];
    RenewUrge(node, a);
  }
}

void Tree::SetUnvisited(Node& node, float value) {
  for (std::size_t a = 0; a < kActionCount; ++a) {
    if (Has(node.legal, a) && node.visits[a] == 0) node.value[a] = value;
  }
}

std::array<float, Node::kLanes> Tree::Scores(const Node& node) const {
  const float exploration = exploration_[node.visit_count];
  const auto side = static_cast<float>(node.side);
  std::array<float, Node::kLanes> scores;
  for (std::size_t lane = 0; lane < Node::kLanes; ++lane) {
    scores[lane] = side * node.value[lane] + exploration * node.urge[lane];
  }
  return scores;
}

Action Tree::Select(const Node& node) const {
  const std::array<float, Node::kLanes> scores = Scores(node);
  std::size_t best = 0;
  for (std::size_t a = 1; a < kActionCount; ++a) {
    if (scores[a] > scores[best]) best = a;
  }
  return static_cast<Action>(best);
}

Action Tree::SelectAmong(const Node& node, ActionSet actions) const {
  const std::array<float, Node::kLanes> scores = Scores(node);
  return BestAction(std::span(scores).first<kActionCount>(), actions);
}

void Tree::Visit(NodeIndex index, Action action) {
  Node& node = (*this)[index];
  const auto a = static_cast<std::size_t>(action);
  ++under_way_[static_cast<std::size_t>(index)][a];
  ++node.visit_count;
  node.urge[a] = node.prior[a] / static_cast<float>(1 + ++node.visits[a]);
}

void Tree::Undo(NodeIndex node) {
  for (NodeIndex child = node; (*this)[child].parent != kNoNode; child = (*this)[child].parent) {
    const NodeIndex index = (*this)[child].parent;
    Node& parent = (*this)[index];
    const auto a = static_cast<std::size_t>((*this)[child].parent_action);
    --under_way_[static_cast<std::size_t>(index)][a];
    --parent.visit_count;
    --parent.visits[a];
    RenewUrge(parent, a);
  }
}

void Tree::BackUp(NodeIndex node, float value) {
  for (NodeIndex child = node; (*this)[child].parent != kNoNode; child = (*this)[child].parent) {
    const NodeIndex index = (*this)[child].parent;
    Node& parent = (*this)[index];
    const auto a = static_cast<std::size_t>((*this)[child].parent_action);
    const std::uint32_t others_under_way = --under_way_[static_cast<std::size_t>(index)][a];
    const auto ended = static_cast<float>(parent.visits[a] - others_under_way);
    parent.value[a] = ended == 1 ? value : parent.value[a] + (value - parent.value[a]) / ended;
  }
}

void Tree::Prove(NodeIndex node) {
  float value = (*this)[node].evaluation;
  for (NodeIndex index = node; (*this)[index].parent != kNoNode; index = (*this)[index].parent) {
    const Node& child = (*this)[index];
    Node& parent = (*this)[child.parent];
    const auto a = static_cast<std::size_t>(child.parent_action);
    parent.value[a] = value;
    if (parent.side < 0 && !enemies_choose_) return;
    if (child.proven != parent.side) {
      parent.closed = static_cast<ActionSet>(parent.closed | 1U << a);
      RenewUrge(parent, a);
      if (parent.closed != parent.legal) return;
      value = BestValue(parent);
    }
    parent.proven = child.proven;
  }
}

}  // namespace powderkeg

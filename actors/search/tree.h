#pragma once

// The search tree: nodes in one array, selection and back-up.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "actors/search/foretelling.h"
#include "common/config/search_settings.h"
#include "common/policies/policy.h"
#include "common/pommerman/state.h"
#include "common/pommerman/step.h"

namespace powderkeg {

using NodeIndex = std::int32_t;
inline constexpr NodeIndex kNoNode = -1;

// A position in which `mover` is to choose. In a one-player tree that is always the searching
// agent. In a two-player tree a node with another mover has the position of its parent, whose
// mover's choice is buffered in `actions` until the environment steps.
//
// The answer to a position may foretell the enemy as well (ModelledAgent::foretold); then the ply
// of that enemy asks nothing, and no simulation ends in it.
//
// All values are the searching agent's view. Per-edge arrays are indexed by Action; those that
// selection reads are padded to eight lanes and lie together.
struct alignas(64) Node {
  enum class Stage : std::uint8_t {
    kNew,         // waits for its evaluation; has no edges yet
    kEvaluated,   // the other agents have not decided yet
    kAsksModels,  // waits for the evaluations that network models act by
    kReady,       // `actions` holds what the models do
    kAsksMate,    // the searching agent died: waits for the mate's view, then terminal
    kTerminal,    // over for the searching agent: `evaluation` is the outcome
  };
  static constexpr std::size_t kLanes = 8;

  // Mean value of the simulations through the edge that have ended; the unvisited value before the
  // first one; infinitely bad for the mover where the action is illegal.
  std::array<float, kLanes> value;
  std::array<float, kLanes> urge;  // prior / (1 + visits)
  std::array<NodeIndex, kActionCount> child;
  std::array<std::uint32_t, kActionCount> visits;  // simulations under way included
  std::uint32_t visit_count;                       // sum of `visits`
  NodeIndex parent;
  float evaluation;                       // the evaluator's value, or the outcome
  std::array<float, kActionCount> prior;  // 0 where illegal
  Action parent_action;
  Stage stage;
  std::uint8_t mover;
  std::uint8_t next_mover;  // who chooses next within this step; `mover` itself: nobody
  std::int8_t side;         // +1: the searching agent moves; -1: an enemy
  ActionSet legal;
  ActionSet closed;    // actions proven to end badly for the mover: never selected again
  std::int8_t proven;  // +1 won, -1 lost for the searching agent whatever comes; 0: not known
  JointAction actions;
  // What the models remember: before they decide on this position, then after it.
  std::array<PolicyMemory, kAgentCount> memories;
  State state;
};

static_assert(std::is_trivially_copyable_v<Node>);
static_assert(sizeof(Node) <= 512);

// Owns the nodes. They stay in place until Clear or Keep. Allocates only in Clear and Keep. One
// thread.
class Tree {
 public:
  explicit Tree(const SearchSettings& settings);

  // Forgets all nodes; makes room for `capacity`.
  void Clear(int capacity);
  // Makes `node` the root, forgets what is not below it, makes room for `more` nodes (and as many
  // simulations).
  void Keep(NodeIndex node, int more);

  // Appends a node without state and edges; `parent` may be kNoNode for the root, node 0. Requires
  // room.
  NodeIndex Add(NodeIndex parent, Action parent_action);

  // Gives a node its edges: what is legal, and the evaluator's policy for it.
  void SetEdges(Node& node, ActionSet legal, std::span<const float, kActionCount> policy) const;
  // Replaces the priors of the legal actions; visits and values stay.
  static void SetPriors(Node& node, std::span<const float, kActionCount> priors);

  // Replaces the values of the legal actions without a visit.
  static void SetUnvisited(Node& node, float value);

  // The action that maximises Q + c(N) P sqrt(N) / (1 + n) for the mover, the lowest of equal ones.
  // N is the number of visits of all edges, at least 1 (so that the first choice follows P).
  [[nodiscard]] Action Select(const Node& node) const;

  // The same of some legal actions.
  [[nodiscard]] Action SelectAmong(const Node& node, ActionSet actions) const;

  // c(N) sqrt(N) of that rule.
  [[nodiscard]] float Exploration(std::size_t visits) const { return exploration_[visits]; }

  // Counts a simulation under way through an edge. It weighs in the choice of actions at once, in
  // the edge's value not before its end (Liu et al. 2020, "Watch the unobserved").
  void Visit(NodeIndex node, Action action);
  // Takes back the visits of a simulation under way from the root to `node`.
  void Undo(NodeIndex node);
  // Ends the simulation that was counted from the root to `node`: averages its value in with those
  // that ended before, whatever else is under way.
  void BackUp(NodeIndex node, float value);
  // Takes in that the end `node` is proven and worth its `evaluation`, which replaces the mean
  // value of the edge to it. Closes the edge where its parent's mover would rather do anything
  // else; proves the parent where that mover would do nothing else, or has nothing else; and so on
  // up to the root, or to a ply whose moves follow their priors: what may happen proves nothing.
  void Prove(NodeIndex node);

  [[nodiscard]] Node& operator[](NodeIndex node) { return nodes_[static_cast<std::size_t>(node)]; }
  [[nodiscard]] const Node& operator[](NodeIndex node) const {
    return nodes_[static_cast<std::size_t>(node)];
  }
  [[nodiscard]] NodeIndex size() const { return size_; }

  // Of a node in which the searching agent moves, if a search with foretold models evaluated it.
  [[nodiscard]] Foretelling& foretold(NodeIndex node) {
    return foretold_[static_cast<std::size_t>(node)];
  }
  [[nodiscard]] const Foretelling& foretold(NodeIndex node) const {
    return foretold_[static_cast<std::size_t>(node)];
  }

 private:
  [[nodiscard]] std::array<float, Node::kLanes> Scores(const Node& node) const;
  void Reserve(std::size_t nodes, std::size_t visits);

  float unvisited_value_;
  bool renormalise_priors_;
  double policy_temperature_;
  bool enemies_choose_;  // and do not follow their priors
  double c_puct_init_;
  double c_puct_base_;
  std::vector<Node> nodes_;  // the first size_ are in use; a child stands behind its parent
  NodeIndex size_ = 0;
  // [node][action]: simulations through the edge that have not ended. All 0 while none is under
  // way.
  std::vector<std::array<std::uint16_t, kActionCount>> under_way_;
  std::vector<Foretelling> foretold_;  // [node]
  std::vector<float> exploration_;     // [N]: c(N) sqrt(N)
  std::vector<NodeIndex> moved_to_;    // scratch of Keep
};

}  // namespace powderkeg

#pragma once

// The search tree: nodes in one array, selection and back-up.

#include <array>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "actors/search/search_settings.h"
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
// All values are the searching agent's view. Per-edge arrays are indexed by Action; those that
// selection reads are padded to eight lanes and lie together.
struct alignas(64) Node {
  enum class Stage : std::uint8_t {
    kNew,          // waits for its evaluation
    kEvaluated,    // the other agents' actions are not known yet
    kAsksModels,   // waits for the evaluations that network models act by
    kReady,        // `actions` holds what the models do
    kAsksForMate,  // waits for the mate's view after the searching agent died; then terminal
    kTerminal,     // the game is over for the searching agent: `evaluation` is the outcome
  };
  static constexpr std::size_t kLanes = 8;

  // Mean value of the simulations through the edge; the unvisited value before the first one; an
  // unreachable one (infinitely bad for the mover) for illegal actions.
  std::array<float, kLanes> value;
  std::array<float, kLanes> urge;  // prior / (1 + visits): exploration without its common factor
  std::array<NodeIndex, kActionCount> child;
  std::array<std::uint32_t, kActionCount> visits;  // simulations under way included
  std::uint32_t visit_count;                       // sum of `visits`
  NodeIndex parent;
  Action parent_action;
  Stage stage;
  std::uint8_t mover;
  ActionSet legal;
  float evaluation;  // the evaluator's value, or the outcome
  std::array<float, kActionCount> prior;
  JointAction actions;
  // Before the models decided on this position: what they remember; afterwards: what they will
  // remember in its children.
  std::array<PolicyMemory, kAgentCount> memories;
  State state;
};

static_assert(std::is_trivially_copyable_v<Node>);
static_assert(sizeof(Node) <= 1024);

// Owns the nodes. Indices stay valid, and nodes in place, until Clear or Keep. One thread.
class Tree {
 public:
  Tree(const SearchSettings& settings, AgentId self);

  // Forgets all nodes, makes room for `capacity`.
  void Clear(std::size_t capacity);
  // Makes `node` the root, forgets what is not below it, and makes room for `more` nodes.
  void Keep(NodeIndex node, std::size_t more);

  // Appends a node with edges but no evaluation. Requires room.
  NodeIndex Add(NodeIndex parent, Action parent_action);
  [[nodiscard]] Node& operator[](NodeIndex node) { return nodes_[static_cast<std::size_t>(node)]; }
  [[nodiscard]] const Node& operator[](NodeIndex node) const {
    return nodes_[static_cast<std::size_t>(node)];
  }
  [[nodiscard]] NodeIndex size() const { return size_; }

 private:
  std::vector<Node> nodes_;
  NodeIndex size_ = 0;
};

}  // namespace powderkeg

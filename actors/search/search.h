#pragma once

// Monte-Carlo tree search over a game whose other players are modelled (Weil et al. 2023).

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "actors/search/ends.h"
#include "actors/search/gumbel_root.h"
#include "actors/search/opponent_models.h"
#include "actors/search/root_policy.h"
#include "actors/search/survival.h"
#include "actors/search/tree.h"
#include "common/base/rng.h"
#include "common/config/search_settings.h"
#include "common/model/evaluator.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"

namespace powderkeg {

// What a search found for its root. Arrays are indexed by Action.
struct SearchResult {
  // False where only one action is legal: nothing was searched, `best` is that action, the rest is
  // empty. Such a move is no Decision to learn from.
  bool searched = false;
  Action best = Action::kStop;                       // to be played
  std::array<std::uint32_t, kActionCount> visits{};  // simulations through each action
  std::array<float, kActionCount> values{};          // mean value, own view; 0 without a visit
  std::array<float, kActionCount> priors{};          // evaluator's policy, illegal ones 0
  // The policy to learn from, as counts that are not all 0. root=puct: the visits, without those of
  // forced playouts and of actions that are proven lost. root=gumbel: the improved policy times
  // kImprovedPolicyScale. A proven win: that action alone.
  std::array<std::uint32_t, kActionCount> target{};
  // False for a fast search (full_search_share): too short to learn its policy.
  bool full_search = true;
  float value = 0;            // of the root: mean over simulations, [-1, 1]
  float evaluator_value = 0;  // the root's evaluation, survivability weighed in (survival.h)
  int simulations = 0;        // made for this move
  int reused_visits = 0;      // kept from the previous move's tree
  double mean_depth = 0;      // environment steps from root to leaf
  int variation_length = 0;   // environment steps along the principal variation: `best`, then the
                              // most visited actions
  // What the models do at the root; bit i of `expected_agents` says that entry i holds (living
  // agents that act by model, once a simulation has stepped from the root).
  JointAction expected_actions{};
  std::uint8_t expected_agents = 0;
};

// Precision of a recorded improved policy: hundredths of a per cent.
inline constexpr double kImprovedPolicyScale = 10'000;

// One search after another for one agent; a state machine that a loop feeds:
//
//   search.Start(root, models, rng);
//   while (search.Gather(batch)) { evaluate batch; search.Scatter(batch); batch.Clear(); }
//   play search.Result().best
//
// A batch may hold the positions of many searches. With the uniform evaluator the result depends on
// nothing but the arguments of Start (and, with tree reuse, of the Starts before). Never blocks,
// allocates only in Start. One thread. Movable, not copyable between Gather and Scatter.
class Search {
 public:
  Search(const SearchSettings& settings, const GameSettings& game);

  // Begins a move of models.self(), which must be alive in `root` (a belief's state). With tree
  // reuse, continues the previous tree if it foresaw this position.
  void Start(const State& root, const OpponentModels& models, Rng rng);

  // Runs simulations until leaves_per_batch of them need an evaluation, 256 at most; adds what they
  // need to the batch, which is nothing where all of them met the end of the game. False when the
  // search is finished: then nothing was added. Requires that earlier answers were scattered.
  bool Gather(EvaluationBatch& batch);

  // Takes the answers to what the last Gather added.
  void Scatter(const EvaluationBatch& batch);

  // May be asked before the end as well (a clock ran out), once the root is evaluated.
  [[nodiscard]] SearchResult Result() const;

  // What the evaluation of the root foretells of the others: nothing where no model asks for it, or
  // nothing was searched.
  [[nodiscard]] Foretelling foretold() const;

  [[nodiscard]] const SearchSettings& settings() const { return settings_; }

  // As it stands; node 0 is the root. To look at, until the next call.
  [[nodiscard]] const Tree& tree() const { return tree_; }

 private:
  // A question in the current batch: what `viewer` thinks of a node.
  struct Pending {
    NodeIndex node;
    AgentId viewer;
    std::size_t slot;
  };

  // Start
  void ChooseLength();
  [[nodiscard]] int NodesToAdd() const;
  void BeginTree(const State& root);
  [[nodiscard]] NodeIndex FindForeseen(const State& root, NodeIndex parent) const;
  void BeginRoot();

  // Gather: one simulation, from the root to a leaf. False if it has to be tried again after the
  // next Scatter.
  bool Simulate(EvaluationBatch& batch);
  [[nodiscard]] Action ChooseAction(NodeIndex node);
  [[nodiscard]] Action ChooseRootAction();
  [[nodiscard]] bool AwaitsAnswers() const;
  bool DecideForOthers(NodeIndex node, EvaluationBatch& batch);
  [[nodiscard]] AgentId NextMover(NodeIndex node) const;
  NodeIndex Expand(NodeIndex parent, Action action);
  void BeginForetoldPly(NodeIndex parent, Node& ply) const;
  void StepEnvironment(const Node& parent, Node& child);
  void ObserveMover(const Node& parent, AgentId agent, Node& child) const;
  void ObserveNetworkMoves(const Node& parent, Node& child) const;
  void ReachLeaf(NodeIndex leaf, EvaluationBatch& batch);
  void Ask(NodeIndex node, AgentId viewer, EvaluationBatch& batch);

  // Scatter
  void TakeEvaluation(NodeIndex node, const Evaluation& evaluation);
  void TakeMateValue(NodeIndex node, float value);
  void TakeModelPolicy(Node& node, AgentId agent, const Evaluation& evaluation) const;
  void EndSimulation(NodeIndex leaf);

  // Result
  [[nodiscard]] int VariationLength(Action first) const;
  [[nodiscard]] std::optional<std::size_t> WinningAction(const Node& node) const;
  [[nodiscard]] ActionSet RootActions() const;
  [[nodiscard]] RootStatistics Candidates() const;
  void ChooseFrom(RootStatistics candidates, SearchResult& result) const;
  void ExpectActions(SearchResult& result) const;

  [[nodiscard]] bool ActsByNetwork(const Node& node, AgentId agent) const;
  [[nodiscard]] ForetoldActions Foretold(NodeIndex node, AgentId agent) const;
  [[nodiscard]] ActionSet LegalFor(const Node& node) const;
  [[nodiscard]] BitBoard VisibleFor(const State& state, AgentId viewer) const;

  SearchSettings settings_;
  SearchSettings move_;  // the same for this move: a fast search differs
  GameSettings game_;    // as the search knows it: without a step limit if that setting is off
  Ends ends_;
  Survival survival_;
  bool foretells_;  // somebody is foretold
  AgentId self_ = 0;
  std::array<ModelledAgent, kAgentCount> models_;
  Rng rng_;
  Tree tree_;
  std::vector<Pending> pending_;
  ActionSet cautious_ = 0;  // of the root's actions those that may be played
  bool forced_ = true;      // nothing to search
  bool full_search_ = true;
  int budget_ = 0;             // simulations of this move
  SequentialHalving halving_;  // of a Gumbel root
  int started_ = 0;            // simulations of this move, those waiting for an answer included
  int finished_ = 0;           // simulations of this move that were backed up
  int reused_visits_ = 0;
  // Exploratory starts of this search by action: what they visit is not learned.
  std::array<std::uint32_t, kActionCount> explored_{};
  std::int64_t depth_sum_ = 0;                     // environment steps over finished simulations
  std::array<float, kActionCount> root_priors_{};  // before noise
};

}  // namespace powderkeg

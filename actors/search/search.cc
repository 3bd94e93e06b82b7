#include "actors/search/search.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "actors/search/deciders.h"
#include "actors/search/enemy_moves.h"
#include "common/base/check.h"
#include "common/pommerman/observation.h"

namespace powderkeg {
namespace {

constexpr ActionSet kAllActions = (1U << kActionCount) - 1;
constexpr NodeIndex kRoot = 0;
// Of one Gather, so that it returns to a caller who watches a clock also where all simulations end
// in outcomes and ask nothing.
constexpr int kMostSimulations = 256;
constexpr std::uint64_t kFullSearchPurpose = 1;  // of the generator split from a move's

bool ActsAlike(const ModelledAgent& a, const ModelledAgent& b) {
  return a.kind == b.kind && a.policy == b.policy;
}

GameSettings AsKnownTo(const SearchSettings& settings, GameSettings game) {
  if (!settings.step_limit) game.max_steps = std::numeric_limits<int>::max();
  return game;
}

// The only action in the set.
Action OnlyOne(ActionSet actions) { return static_cast<Action>(std::countr_zero(actions)); }

std::uint32_t AsCount(double share) {
  return static_cast<std::uint32_t>(share * kImprovedPolicyScale + 0.5);
}

}  // namespace

Search::Search(const SearchSettings& settings, const GameSettings& game)
    : settings_(settings),
      move_(settings),
      game_(AsKnownTo(settings, game)),
      ends_(settings, game),
      survival_(settings, game_),
      foretells_(Predicts(settings)),
      tree_(settings) {
  pending_.reserve(static_cast<std::size_t>(settings.leaves_per_batch + kAgentCount));
}

// --- Start -------------------------------------------------------------------------------------

void Search::Start(const State& root, const OpponentModels& models, Rng rng) {
  CHECK(root.agents[models.self()].alive, "agent ", models.self(), " is dead");
  CHECK(pending_.empty(), "Start between Gather and Scatter");
  std::array<ModelledAgent, kAgentCount> known;
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    if (agent != models.self()) known[static_cast<std::size_t>(agent)] = models.Of(agent);
  }
  const bool has_tree = finished_ > 0 || (tree_.size() > 0 && tree_[kRoot].proven != 0);
  const bool foresight = settings_.tree_reuse && self_ == models.self() && has_tree &&
                         std::ranges::equal(known, models_, ActsAlike);
  self_ = models.self();
  models_ = known;
  rng_ = rng;
  started_ = finished_ = reused_visits_ = 0;
  explored_.fill(0);
  depth_sum_ = 0;
  ChooseLength();
  const NodeIndex foreseen = foresight ? FindForeseen(root, kRoot) : kNoNode;
  if (foreseen == kNoNode) {
    BeginTree(root);
  } else {
    tree_.Keep(foreseen, NodesToAdd());
  }
  cautious_ = survival_.CautiousActions(root, self_, LegalFor(tree_[kRoot]));
  BeginRoot();
}

// Playout cap randomisation (Wu 2019, 3.1): most searches are short, and play as well as they can.
void Search::ChooseLength() {
  full_search_ = settings_.full_search_share >= 1 ||
                 rng_.Split(kFullSearchPurpose).Uniform() < settings_.full_search_share;
  move_ = full_search_ ? settings_ : WithoutExploration(settings_);
  if (!full_search_) move_.simulations = settings_.fast_simulations;
  budget_ = move_.simulations;
}

// By the simulations of this move: each adds a node, and the ply of a foretold enemy before it.
int Search::NodesToAdd() const {
  return settings_.tree == TreeKind::kTwoPlayer ? 2 * budget_ : budget_;
}

void Search::BeginTree(const State& root) {
  tree_.Clear(1 + NodesToAdd());
  Node& node = tree_[tree_.Add(kNoNode, Action::kStop)];
  node.state = root;
  node.mover = static_cast<std::uint8_t>(self_);
  node.side = 1;
  node.actions.fill(Action::kStop);
  for (std::size_t agent = 0; agent < kAgentCount; ++agent) {
    node.memories[agent] = models_[agent].memory;
  }
}

// The evaluated node one environment step below `parent` that has this position.
NodeIndex Search::FindForeseen(const State& root, NodeIndex parent) const {
  for (const NodeIndex index : tree_[parent].child) {
    if (index == kNoNode) continue;
    const Node& child = tree_[index];
    if (child.stage != Node::Stage::kEvaluated && child.stage != Node::Stage::kReady) continue;
    if (child.mover != self_) {
      const NodeIndex found = FindForeseen(root, index);
      if (found != kNoNode) return found;
    } else if (child.state == root) {
      return index;
    }
  }
  return kNoNode;
}

// What holds for new and kept roots alike: is there anything to search; if it is already evaluated,
// what its untried actions are worth, and noise.
void Search::BeginRoot() {
  Node& root = tree_[kRoot];
  forced_ = std::popcount(LegalFor(root)) == 1;
  if (root.stage == Node::Stage::kNew) return;
  Tree::SetUnvisited(root, static_cast<float>(settings_.root_unvisited_value));
  reused_visits_ = static_cast<int>(root.visit_count);
  root_priors_ = root.prior;
  if (root.proven != 0) budget_ = 0;
  if (settings_.root == RootSearch::kGumbel) {
    if (root.proven == 0) halving_.Start(move_, Candidates(), rng_);
  } else if (move_.noise_weight > 0) {
    Tree::SetPriors(root, WithNoise(move_, root_priors_, root.legal, rng_));
  }
}

// --- Gather ------------------------------------------------------------------------------------

bool Search::Gather(EvaluationBatch& batch) {
  CHECK(pending_.empty(), "Gather before the last answers were scattered");
  if (forced_ || tree_.size() == 0) return false;
  if (tree_[kRoot].stage == Node::Stage::kNew) {
    Ask(kRoot, self_, batch);
    return true;
  }
  const auto most = static_cast<std::size_t>(settings_.leaves_per_batch);
  const int pause = started_ + kMostSimulations;
  while (started_ < std::min(budget_, pause) && pending_.size() < most) {
    if (AwaitsAnswers() || !Simulate(batch)) break;
  }
  return !pending_.empty() || started_ < budget_;
}

// Whether the next simulation's first action depends on answers that are still to come.
bool Search::AwaitsAnswers() const {
  return settings_.root == RootSearch::kGumbel && started_ > finished_ && halving_.phase_is_over();
}

bool Search::Simulate(EvaluationBatch& batch) {
  NodeIndex index = kRoot;
  for (;;) {
    Node& node = tree_[index];
    if (node.stage == Node::Stage::kTerminal) break;
    const bool can_go_on = node.stage == Node::Stage::kReady ||
                           (node.stage == Node::Stage::kEvaluated && DecideForOthers(index, batch));
    if (!can_go_on) {
      tree_.Undo(index);
      if (index != kRoot && settings_.root == RootSearch::kGumbel) halving_.TakeBack();
      return false;
    }
    const Action action = ChooseAction(index);
    tree_.Visit(index, action);
    const NodeIndex child = node.child[static_cast<std::size_t>(action)];
    index = child == kNoNode ? Expand(index, action) : child;
    if (child == kNoNode && tree_[index].stage != Node::Stage::kReady) break;
  }
  ++started_;
  ReachLeaf(index, batch);
  return true;
}

Action Search::ChooseAction(NodeIndex index) {
  if (index == kRoot) return ChooseRootAction();
  const Node& node = tree_[index];
  return node.side > 0 ? tree_.Select(node) : ChooseEnemyMove(settings_, tree_, node);
}

Action Search::ChooseRootAction() {
  const Node& root = tree_[kRoot];
  if (settings_.root == RootSearch::kGumbel) return halving_.Next(Candidates());
  if (move_.exploratory_start != 0 && rng_.Uniform() < move_.exploratory_start) {
    unsigned remaining = root.legal & ~static_cast<unsigned>(root.closed);
    std::uint32_t skip = rng_.Below(static_cast<std::uint32_t>(std::popcount(remaining)));
    for (; skip > 0; --skip) remaining &= remaining - 1;
    const Action action = OnlyOne(static_cast<ActionSet>(remaining));
    ++explored_[static_cast<std::size_t>(action)];
    return action;
  }
  if (move_.forced_playouts > 0) {
    const std::size_t forced = ForcedAction(move_.forced_playouts, Candidates());
    if (forced < kActionCount) return static_cast<Action>(forced);
  }
  return tree_.SelectAmong(root, RootActions());
}

// Fills in `actions` for everybody who does not choose in the tree; false if networks are asked.
bool Search::DecideForOthers(NodeIndex index, EvaluationBatch& batch) {
  Node& node = tree_[index];
  node.next_mover = static_cast<std::uint8_t>(NextMover(index));
  node.stage = Node::Stage::kReady;
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    const auto id = static_cast<std::size_t>(agent);
    node.actions[id] = Action::kStop;
    if (agent == self_ || agent == node.next_mover || !node.state.agents[agent].alive) continue;
    if (ActsByNetwork(node, agent)) {
      node.stage = Node::Stage::kAsksModels;
      Ask(index, agent, batch);
      continue;
    }
    const ModelledAgent& known = models_[id];
    if (known.kind == ModelledAgent::Kind::kPredicted) {
      const ActionSet legal = LegalActions(node.state, agent);
      const ForetoldActions foretold = Foretold(index, agent);
      node.actions[id] = settings_.predicted_drawn ? DrawnAction(foretold, legal, rng_)
                                                   : BestAction(foretold, legal);
      continue;
    }
    const PolicyView view{node.state, game_, agent, VisibleFor(node.state, agent)};
    node.actions[id] = Decide(known.policy, view, known.traits, node.memories[id], rng_);
  }
  return node.stage == Node::Stage::kReady;
}

// The enemy whose moves branch in this step, or self: so where the answer should foretell that
// enemy and says nothing of it, which is out of sight.
AgentId Search::NextMover(NodeIndex index) const {
  const AgentId enemy = DeciderAfter(settings_, game_, tree_[index].state, self_);
  if (!models_[static_cast<std::size_t>(enemy)].foretold) return enemy;
  return SumOf(Foretold(index, enemy), kAllActions) == 0 ? self_ : enemy;
}

NodeIndex Search::Expand(NodeIndex parent_index, Action action) {
  const NodeIndex index = tree_.Add(parent_index, action);
  const Node& parent = tree_[parent_index];
  Node& child = tree_[index];
  child.actions = parent.actions;
  child.actions[parent.mover] = action;
  child.memories = parent.memories;
  child.state = parent.state;
  child.mover = parent.next_mover;
  child.next_mover = child.mover;
  child.side = child.mover == self_ ? 1 : -1;
  if (parent.mover == parent.next_mover) {
    StepEnvironment(parent, child);
  } else if (models_[child.mover].foretold) {
    BeginForetoldPly(parent_index, child);
  }
  return index;
}

// The answer to the position in which self decides tells what the enemy will do in it, too: nothing
// is asked, and simulations go on through the ply to the position after the step. So none ends in
// it, and its own evaluation, that of the same answer, is never backed up.
void Search::BeginForetoldPly(NodeIndex parent, Node& ply) const {
  constexpr float kWhole = 255;
  std::array<float, kActionCount> policy;
  std::ranges::transform(Foretold(parent, ply.mover), policy.begin(),
                         [](std::uint8_t share) { return static_cast<float>(share) / kWhole; });
  tree_.SetEdges(ply, LegalFor(ply), policy);
  ply.evaluation = tree_[parent].evaluation;
  ply.stage = Node::Stage::kReady;
}

// Everybody's action is known: plays them.
void Search::StepEnvironment(const Node& parent, Node& child) {
  const Outcome outcome = Advance(game_, child.actions, child.state);
  if (parent.mover != self_) ObserveMover(parent, parent.mover, child);
  if (settings_.raw_network_depth > 0) ObserveNetworkMoves(parent, child);
  child.mover = child.next_mover = static_cast<std::uint8_t>(self_);
  child.side = 1;
  ends_.Judge(outcome, self_, child);
}

// Somebody acted otherwise than by its rule-based model, which may act next time.
void Search::ObserveMover(const Node& parent, AgentId agent, Node& child) const {
  const auto id = static_cast<std::size_t>(agent);
  ObserveMove(models_[id].policy, parent.state.agents[id].cell, child.state.agents[id].cell,
              child.memories[id]);
}

void Search::ObserveNetworkMoves(const Node& parent, Node& child) const {
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    if (agent == self_ || agent == parent.mover || !parent.state.agents[agent].alive) continue;
    if (ActsByNetwork(parent, agent)) ObserveMover(parent, agent, child);
  }
}

void Search::ReachLeaf(NodeIndex leaf, EvaluationBatch& batch) {
  switch (tree_[leaf].stage) {
    case Node::Stage::kTerminal: EndSimulation(leaf); break;
    case Node::Stage::kAsksMate: Ask(leaf, TeamMateOf(game_.mode, self_), batch); break;
    default: Ask(leaf, tree_[leaf].mover, batch); break;
  }
}

void Search::Ask(NodeIndex node, AgentId viewer, EvaluationBatch& batch) {
  const State& state = tree_[node].state;
  pending_.push_back({node, viewer, batch.Add({&state, viewer, VisibleFor(state, viewer)})});
}

// --- Scatter -----------------------------------------------------------------------------------

void Search::Scatter(const EvaluationBatch& batch) {
  for (const Pending& pending : pending_) {
    const Evaluation& evaluation = batch.evaluation(pending.slot);
    Node& node = tree_[pending.node];
    switch (node.stage) {
      case Node::Stage::kAsksModels: TakeModelPolicy(node, pending.viewer, evaluation); break;
      case Node::Stage::kAsksMate: TakeMateValue(pending.node, evaluation.value); break;
      default: TakeEvaluation(pending.node, evaluation); break;
    }
  }
  for (const Pending& pending : pending_) {
    Node& node = tree_[pending.node];
    if (node.stage == Node::Stage::kAsksModels) node.stage = Node::Stage::kReady;
  }
  pending_.clear();
}

void Search::TakeEvaluation(NodeIndex index, const Evaluation& evaluation) {
  Node& node = tree_[index];
  tree_.SetEdges(node, LegalFor(node), evaluation.policy);
  node.evaluation =
      survival_.Weigh(static_cast<float>(node.side) * evaluation.value, node.state, self_);
  node.stage = node.mover == self_ ? Node::Stage::kEvaluated : Node::Stage::kReady;
  if (foretells_) tree_.foretold(index) = evaluation.others;
  if (index == kRoot) {
    BeginRoot();
  } else {
    EndSimulation(index);
  }
}

void Search::TakeMateValue(NodeIndex index, float value) {
  tree_[index].evaluation = value;
  tree_[index].stage = Node::Stage::kTerminal;
  EndSimulation(index);
}

void Search::TakeModelPolicy(Node& node, AgentId agent, const Evaluation& evaluation) const {
  node.actions[static_cast<std::size_t>(agent)] =
      BestAction(evaluation.policy, LegalActions(node.state, agent));
}

void Search::EndSimulation(NodeIndex leaf) {
  tree_.BackUp(leaf, tree_[leaf].evaluation);
  if (settings_.terminal_solver && tree_[leaf].proven != 0) {
    tree_.Prove(leaf);
    if (tree_[kRoot].proven != 0) budget_ = started_;
  }
  ++finished_;
  depth_sum_ += tree_[leaf].state.step - tree_[kRoot].state.step;
}

// --- Result ------------------------------------------------------------------------------------

SearchResult Search::Result() const {
  SearchResult result;
  const Node& root = tree_[kRoot];
  result.searched = !forced_;
  result.full_search = full_search_;
  if (forced_) {
    result.best = OnlyOne(LegalFor(root));
    return result;
  }
  CHECK(root.stage != Node::Stage::kNew, "no result before the root is evaluated");
  double value_sum = 0;
  for (std::size_t a = 0; a < kActionCount; ++a) {
    result.visits[a] = root.visits[a];
    if (root.visits[a] == 0) continue;
    result.values[a] = root.value[a];
    value_sum += static_cast<double>(root.visits[a]) * static_cast<double>(root.value[a]);
  }
  result.priors = root_priors_;
  result.evaluator_value = root.evaluation;
  result.value =
      root.visit_count == 0 ? root.evaluation : static_cast<float>(value_sum / root.visit_count);
  ChooseFrom(Candidates(), result);
  if (root.proven != 0) result.value = root.value[static_cast<std::size_t>(result.best)];
  result.simulations = finished_;
  result.reused_visits = reused_visits_;
  if (finished_ > 0) result.mean_depth = static_cast<double>(depth_sum_) / finished_;
  result.variation_length = VariationLength(result.best);
  ExpectActions(result);
  return result;
}

int Search::VariationLength(Action first) const {
  const Node* node = &tree_[kRoot];
  for (NodeIndex next = node->child[static_cast<std::size_t>(first)]; next != kNoNode;) {
    node = &tree_[next];
    if (node->visit_count == 0) break;
    next = node->child[static_cast<std::size_t>(std::ranges::max_element(node->visits) -
                                                node->visits.begin())];
  }
  return node->state.step - tree_[kRoot].state.step;
}

Foretelling Search::foretold() const {
  const bool known = foretells_ && tree_.size() > 0 && tree_[kRoot].stage != Node::Stage::kNew;
  return known ? tree_.foretold(kRoot) : Foretelling{};
}

// What a winning mover does: the best of the actions that are proven won, if there are any.
std::optional<std::size_t> Search::WinningAction(const Node& node) const {
  std::optional<std::size_t> best;
  for (std::size_t a = 0; a < kActionCount; ++a) {
    if (node.child[a] == kNoNode || tree_[node.child[a]].proven <= 0) continue;
    if (!best || node.value[a] > node.value[*best]) best = a;
  }
  return best;
}

// What the root may do: only the winning action where one is proven, else none of those that are
// proven lost, unless all are, and none that lacks caution, unless all others are lost.
ActionSet Search::RootActions() const {
  const Node& root = tree_[kRoot];
  if (root.proven > 0) return static_cast<ActionSet>(1U << WinningAction(root).value());
  const auto open = static_cast<ActionSet>(root.legal & ~root.closed);
  const auto cautious = static_cast<ActionSet>(open & cautious_);
  if (cautious != 0) return cautious;
  return open != 0 ? open : root.legal;
}

// The root as the choice among its actions sees it.
RootStatistics Search::Candidates() const {
  const Node& root = tree_[kRoot];
  RootStatistics candidates;
  candidates.evaluation = root.evaluation;
  candidates.legal = RootActions();
  for (std::size_t a = 0; a < kActionCount; ++a) {
    if (!Has(candidates.legal, a)) continue;
    candidates.priors[a] = root.prior[a];
    candidates.visits[a] = root.visits[a];
    if (root.visits[a] > 0) candidates.values[a] = root.value[a];
  }
  return candidates;
}

// The move and what is to be learned.
void Search::ChooseFrom(RootStatistics candidates, SearchResult& result) const {
  const Node& root = tree_[kRoot];
  if (settings_.root == RootSearch::kGumbel && root.proven == 0) {
    result.best = halving_.Best(candidates);
    std::ranges::transform(ImprovedPolicy(settings_, candidates), result.target.begin(), AsCount);
    return;
  }
  const double exploration = static_cast<double>(tree_.Exploration(root.visit_count));
  RootStatistics learned = candidates;
  for (std::size_t a = 0; a < kActionCount; ++a) {
    learned.visits[a] -= std::min(learned.visits[a], explored_[a]);
  }
  result.target = move_.forced_playouts > 0
                      ? WithoutForced(move_.forced_playouts, exploration, learned)
                      : learned.visits;
  candidates.priors = root_priors_;
  result.best = ChooseMove(move_, candidates, rng_);
  const bool learnable = std::ranges::any_of(result.target, [](auto count) { return count > 0; });
  if (!learnable) result.target[static_cast<std::size_t>(result.best)] = 1;
}

void Search::ExpectActions(SearchResult& result) const {
  const Node& root = tree_[kRoot];
  if (root.stage != Node::Stage::kReady) return;
  result.expected_actions = root.actions;
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    if (agent == self_ || agent == root.next_mover || !root.state.agents[agent].alive) continue;
    result.expected_agents = static_cast<std::uint8_t>(result.expected_agents | 1U << agent);
  }
}

ActionSet Search::LegalFor(const Node& node) const {
  return settings_.action_filter ? LegalActions(node.state, node.mover) : kAllActions;
}

bool Search::ActsByNetwork(const Node& node, AgentId agent) const {
  return models_[static_cast<std::size_t>(agent)].kind == ModelledAgent::Kind::kNetwork ||
         node.state.step - tree_[kRoot].state.step < settings_.raw_network_depth;
}

ForetoldActions Search::Foretold(NodeIndex node, AgentId agent) const {
  return ForetoldOf(tree_.foretold(node), self_, agent);
}

BitBoard Search::VisibleFor(const State& state, AgentId viewer) const {
  if (game_.view_radius == 0) return BitBoard::All();
  return VisibleCells(game_, state.agents[static_cast<std::size_t>(viewer)].cell);
}

}  // namespace powderkeg

#include "actors/search/order_inference.h"

#include <algorithm>
#include <limits>
#include <span>

namespace powderkeg {
namespace {

// How much a decision speaks against a guess: a foreseen action not at all, a drawn one a little,
// another one clearly (but what is hidden in the position may be to blame).
constexpr int kDrawnCost = 2;
constexpr int kWrongCost = 5;
constexpr std::size_t kMostEvidence = 32;  // the oldest goes first
constexpr int kProbes = 8;                 // random orders that show whether a decision depends
constexpr int kProposals = 8;              // steps of the walk per observed decision

struct Prediction {
  Action action;
  bool drawn;

  friend bool operator==(const Prediction& a, const Prediction& b) {
    return a.drawn == b.drawn && (a.drawn || a.action == b.action);
  }
};

Prediction Predict(const PolicyView& view, const PolicyTraits& traits, PolicyMemory memory) {
  const Rng before(1);
  Rng rng = before;
  const Action action = Decide(PolicyKind::kSimpleUnbiased, view, traits, memory, rng);
  return {action, !(rng == before)};
}

int CostOf(const Prediction& prediction, Action seen) {
  if (prediction.drawn) return kDrawnCost;
  return prediction.action == seen ? 0 : kWrongCost;
}

// The orders of three, as places after self.
constexpr std::array<std::array<std::uint8_t, 3>, 6> kOrdersOfThree = {
    {{1, 2, 3}, {1, 3, 2}, {2, 1, 3}, {2, 3, 1}, {3, 1, 2}, {3, 2, 1}}};

// The n-th order of the agents other than self, self last (it is nobody's own target).
std::array<std::uint8_t, kAgentCount> AgentOrder(AgentId self, std::size_t n) {
  std::array<std::uint8_t, kAgentCount> order{};
  for (std::size_t i = 0; i < 3; ++i) {
    order[i] = static_cast<std::uint8_t>((self + kOrdersOfThree[n][i]) % kAgentCount);
  }
  order[3] = static_cast<std::uint8_t>(self);
  return order;
}

// Moves one random element to a random place.
void MoveOne(std::span<std::uint8_t> order, Rng& rng) {
  const auto size = static_cast<std::uint32_t>(order.size());
  const auto from = order.begin() + rng.Below(size);
  const auto to = order.begin() + rng.Below(size);
  if (from < to) {
    std::rotate(from, from + 1, to + 1);
  } else {
    std::rotate(to, from, from + 1);
  }
}

}  // namespace

bool SeenAction(const State& before, const State& after, AgentId agent, Action& action) {
  const AgentState& old = before.agents[static_cast<std::size_t>(agent)];
  const Cell cell = after.agents[static_cast<std::size_t>(agent)].cell;
  if (cell == old.cell) {
    action = Action::kBomb;
    return after.bomb_cells.Has(cell) && !before.bomb_cells.Has(cell);
  }
  for (const Direction direction : kDirections) {
    if (Neighbour(old.cell, direction) != cell) continue;
    action = ActionOf(direction);
    return true;
  }
  return false;
}

void OrderInference::Start(const PolicyTraits& traits, Rng rng) {
  traits_ = traits;
  rng_ = rng;
  agent_order_costs_.fill(0);
  evidence_.clear();
}

void OrderInference::Observe(const PolicyView& view, const PolicyMemory& memory, Action seen) {
  if (JudgeAgentOrders(view, memory, seen)) return;
  if (DependsOnCells(view, memory)) {
    if (evidence_.size() == kMostEvidence) evidence_.erase(evidence_.begin());
    evidence_.push_back({view.state, view.visible, memory, seen});
  }
  Improve(view.settings, view.self);
}

bool OrderInference::JudgeAgentOrders(const PolicyView& view, const PolicyMemory& memory,
                                      Action seen) {
  std::array<Prediction, kAgentOrders> predictions;
  PolicyTraits traits = traits_;
  for (std::size_t n = 0; n < kAgentOrders; ++n) {
    traits.agent_order = AgentOrder(view.self, n);
    predictions[n] = Predict(view, traits, memory);
  }
  const auto differs = [&](const Prediction& other) { return !(other == predictions[0]); };
  if (std::ranges::none_of(predictions, differs)) return false;
  for (std::size_t n = 0; n < kAgentOrders; ++n) {
    agent_order_costs_[n] += powderkeg::CostOf(predictions[n], seen);
  }
  const auto best = std::ranges::min_element(agent_order_costs_) - agent_order_costs_.begin();
  traits_.agent_order = AgentOrder(view.self, static_cast<std::size_t>(best));
  return true;
}

bool OrderInference::DependsOnCells(const PolicyView& view, const PolicyMemory& memory) {
  const Prediction guess = Predict(view, traits_, memory);
  for (int i = 0; i < kProbes; ++i) {
    PolicyTraits probe = PolicyTraits::Draw(rng_);
    probe.agent_order = traits_.agent_order;
    if (!(Predict(view, probe, memory) == guess)) return true;
  }
  return false;
}

int OrderInference::CostOf(const PolicyTraits& traits, const GameSettings& game, AgentId agent,
                           int enough) const {
  int cost = 0;
  for (const Evidence& evidence : evidence_) {
    const PolicyView view{evidence.state, game, agent, evidence.visible};
    cost += powderkeg::CostOf(Predict(view, traits, evidence.memory), evidence.seen);
    if (cost > enough) break;
  }
  return cost;
}

void OrderInference::Improve(const GameSettings& game, AgentId agent) {
  int cost = CostOf(traits_, game, agent, std::numeric_limits<int>::max());
  for (int i = 0; i < kProposals && cost > 0; ++i) {
    PolicyTraits proposal = traits_;
    MoveOne(rng_.Below(2) == 0 ? std::span<std::uint8_t>(proposal.row_order)
                               : std::span<std::uint8_t>(proposal.column_order),
            rng_);
    const int proposed_cost = CostOf(proposal, game, agent, cost);
    if (proposed_cost > cost) continue;
    traits_ = proposal;
    cost = proposed_cost;
  }
}

}  // namespace powderkeg

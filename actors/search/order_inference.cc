#include "actors/search/order_inference.h"

#include <algorithm>
#include <bit>
#include <span>

#include "common/pommerman/step.h"

namespace powderkeg {
namespace {

// What a decision says against a guess: nothing if it was foreseen, one bit if it was drawn (often
// of two moves), and more otherwise, not everything, as what is hidden in the position may be to
// blame.
constexpr int kDrawnCost = 1;
constexpr int kWrongCost = 6;
constexpr int kDuels = 4;      // of each guess with others, at a new escape
constexpr int kSteps = 16;     // of each guess's walk, at a new escape
constexpr int kForesight = 6;  // moves of an escape that Settle looks at

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

// True with probability 2^-bits.
bool HappensInBits(int bits, Rng& rng) { return std::countr_zero(rng.Next()) >= bits; }

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

// Moves one random element to another random place.
void MoveOne(std::span<std::uint8_t> order, Rng& rng) {
  const auto size = static_cast<std::uint32_t>(order.size());
  const std::uint32_t place = rng.Below(size);
  const auto from = order.begin() + place;
  const auto to = order.begin() + (place + 1 + rng.Below(size - 1)) % size;
  if (from < to) {
    std::rotate(from, from + 1, to + 1);
  } else {
    std::rotate(to, from, from + 1);
  }
}

// As if the agent had laid a bomb in the step before.
void LayBomb(AgentId agent, State& state) {
  const AgentState& owner = state.agents[static_cast<std::size_t>(agent)];
  if (state.bomb_cells.Has(owner.cell) || state.bomb_count == kMaxBombs) return;
  Bomb bomb{.cell = owner.cell, .life = 9, .blast_strength = owner.blast_strength};
  bomb.set_owner(agent);
  state.AddBomb(bomb);
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
  for (Guess& guess : guesses_) guess = {PolicyTraits::Draw(rng_)};
  settled_ = 0;
  guesses_[settled_].traits = traits;
  evidence_.clear();
  oldest_ = 0;
}

void OrderInference::Observe(const PolicyView& view, const PolicyMemory& memory, Action seen) {
  const Escape escape(view);
  if (!escape.in_danger()) {
    LearnAgentOrder(view, memory, seen);
  } else if (escape.possible() && IsMove(seen)) {
    LearnCells({escape, DirectionOf(seen)});
  }
}

void OrderInference::LearnAgentOrder(const PolicyView& view, const PolicyMemory& memory,
                                     Action seen) {
  PolicyTraits traits = traits_;
  for (std::size_t n = 0; n < kAgentOrders; ++n) {
    traits.agent_order = AgentOrder(view.self, n);
    agent_order_costs_[n] += powderkeg::CostOf(Predict(view, traits, memory), seen);
  }
  const auto best = std::ranges::min_element(agent_order_costs_) - agent_order_costs_.begin();
  traits_.agent_order = AgentOrder(view.self, static_cast<std::size_t>(best));
}

void OrderInference::LearnCells(const Evidence& evidence) {
  const auto foresaw = [&](const Guess& guess) { return evidence.CostOf(guess.traits) == 0; };
  if (std::ranges::all_of(guesses_, foresaw)) return;
  Keep(evidence);
  Resample(evidence);
  for (Guess& guess : guesses_) {
    for (int i = 0; i < kSteps; ++i) Walk(guess);
  }
}

int OrderInference::Evidence::CostOf(const PolicyTraits& traits) const {
  const Direction move = escape.Choose(traits);
  if (move == Direction::kNone) return kDrawnCost;
  return move == seen ? 0 : kWrongCost;
}

void OrderInference::Keep(const Evidence& evidence) {
  if (evidence_.size() < kMostEvidence) {
    evidence_.push_back(evidence);
    return;
  }
  for (Guess& guess : guesses_) guess.cost -= evidence_[oldest_].CostOf(guess.traits);
  evidence_[oldest_] = evidence;
  oldest_ = (oldest_ + 1) % kMostEvidence;
}

// The worse of two takes over the better, but for the probability that it stands in its place.
void OrderInference::Resample(const Evidence& evidence) {
  std::array<int, kGuesses> costs{};
  for (std::size_t i = 0; i < kGuesses; ++i) {
    costs[i] = evidence.CostOf(guesses_[i].traits);
    guesses_[i].cost += costs[i];
  }
  for (std::size_t i = 0; i < kGuesses; ++i) {
    for (int duel = 0; duel < kDuels; ++duel) {
      const std::size_t other = rng_.Below(kGuesses);
      const int worse_by = costs[i] - costs[other];
      if (worse_by <= 0 || HappensInBits(worse_by, rng_)) continue;
      guesses_[i] = guesses_[other];
      costs[i] = costs[other];
    }
  }
}

// One step, taken with probability 2^-(what it costs more).
void OrderInference::Walk(Guess& guess) {
  PolicyTraits proposal = guess.traits;
  MoveOne(rng_.Below(2) == 0 ? std::span<std::uint8_t>(proposal.row_order)
                             : std::span<std::uint8_t>(proposal.column_order),
          rng_);
  const int enough = guess.cost + std::countr_zero(rng_.Next());
  const int cost = CostOf(proposal, enough);
  if (cost <= enough) guess = {proposal, cost};
}

int OrderInference::CostOf(const PolicyTraits& traits, int enough) const {
  int cost = 0;
  for (auto evidence = evidence_.rbegin(); evidence != evidence_.rend() && cost <= enough;
       ++evidence) {
    cost += evidence->CostOf(traits);
  }
  return cost;
}

void OrderInference::Settle(const PolicyView& view) {
  const auto self = static_cast<std::size_t>(view.self);
  State ahead = view.state;
  if (!Escape(view).in_danger()) LayBomb(view.self, ahead);
  std::array<int, kGuesses> agreement{};
  for (int move = 0; move < kForesight && ahead.agents[self].alive; ++move) {
    const Escape escape({ahead, view.settings, view.self, view.visible});
    if (!escape.in_danger()) break;
    JointAction actions{};
    actions[self] = ActionOf(Vote(escape, move == 0 ? kForesight : 1, agreement));
    Step(view.settings, actions, ahead);
  }
  const auto most = std::ranges::max_element(agreement);
  if (*most > agreement[settled_]) settled_ = static_cast<std::size_t>(most - agreement.begin());
  traits_.row_order = guesses_[settled_].traits.row_order;
  traits_.column_order = guesses_[settled_].traits.column_order;
}

Direction OrderInference::Vote(const Escape& escape, int weight,
                               std::array<int, kGuesses>& agreement) const {
  std::array<Direction, kGuesses> moves{};
  std::array<int, kDirections.size() + 1> votes{};
  for (std::size_t i = 0; i < kGuesses; ++i) {
    moves[i] = escape.Choose(guesses_[i].traits);
    // Who finds no move draws one, and is right half as often.
    votes[static_cast<std::size_t>(moves[i])] += moves[i] == Direction::kNone ? 1 : 2;
  }
  const auto most = static_cast<Direction>(std::ranges::max_element(votes) - votes.begin());
  for (std::size_t i = 0; i < kGuesses; ++i) {
    if (moves[i] == most) agreement[i] += weight;
  }
  return most;
}

}  // namespace powderkeg

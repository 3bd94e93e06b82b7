#include "actors/search/opponent_models.h"

#include "common/pommerman/observation.h"

namespace powderkeg {
namespace {

// The policy a model starts with.
PolicyKind PolicyOf(OpponentModel model) {
  switch (model) {
    case OpponentModel::kIdle: return PolicyKind::kIdle;
    case OpponentModel::kRandom: return PolicyKind::kRandom;
    case OpponentModel::kHarmless: return PolicyKind::kHarmless;
    case OpponentModel::kOfficialSimple: return PolicyKind::kOfficialSimple;
    case OpponentModel::kSimpleUnbiased:
    case OpponentModel::kObserved:
    case OpponentModel::kChosen:
    case OpponentModel::kPredicted:
    case OpponentModel::kRawNetwork: break;
  }
  return PolicyKind::kSimpleUnbiased;
}

ModelledAgent::Kind KindOf(OpponentModel model) {
  switch (model) {
    case OpponentModel::kPredicted: return ModelledAgent::Kind::kPredicted;
    case OpponentModel::kRawNetwork: return ModelledAgent::Kind::kNetwork;
    default: return ModelledAgent::Kind::kPolicy;
  }
}

bool InView(const SeenState& seen, AgentId agent) {
  return seen.visible.Has(seen.state.agents[static_cast<std::size_t>(agent)].cell);
}

}  // namespace

OpponentModel ModelOf(const ModelledAgent& agent) {
  switch (agent.kind) {
    case ModelledAgent::Kind::kPredicted: return OpponentModel::kPredicted;
    case ModelledAgent::Kind::kNetwork: return OpponentModel::kRawNetwork;
    case ModelledAgent::Kind::kPolicy: break;
  }
  switch (agent.policy) {
    case PolicyKind::kIdle: return OpponentModel::kIdle;
    case PolicyKind::kRandom: return OpponentModel::kRandom;
    case PolicyKind::kHarmless: return OpponentModel::kHarmless;
    case PolicyKind::kSimpleUnbiased: return OpponentModel::kSimpleUnbiased;
    case PolicyKind::kOfficialSimple: break;
  }
  return OpponentModel::kOfficialSimple;
}

void OpponentModels::StartGame(const SearchSettings& settings, const GameSettings& game,
                               AgentId self, Rng rng) {
  memory_ = settings.memory;
  game_ = game;
  self_ = self;
  others_.fill(Other());
  for (int i = 1; i < kAgentCount; ++i) {
    const auto id = static_cast<std::size_t>((self + i) % kAgentCount);
    const bool is_mate =
        IsTeamMode(game.mode) && static_cast<AgentId>(id) == TeamMateOf(game.mode, self);
    const OpponentModel listed = settings.opponents[static_cast<std::size_t>(i - 1)];
    const OpponentModel assumed = is_mate ? settings.mate_model.value_or(listed) : listed;
    Other& other = others_[id];
    other.model.kind = KindOf(assumed);
    other.model.policy = PolicyOf(assumed);
    const bool may_be_predicted = assumed == OpponentModel::kChosen;
    other.model.foretold = may_be_predicted || assumed == OpponentModel::kPredicted;
    other.model.traits = PolicyTraits::Draw(rng);
    other.chooses = may_be_predicted || assumed == OpponentModel::kObserved;
    other.choice.Start(memory_, may_be_predicted, rng.Split(kAgentCount + id));
    other.rng = rng.Split(2 * kAgentCount + id);
    other.orders.Start(other.model.traits, rng.Split(id));
  }
}

void OpponentModels::KnowTraits(AgentId agent, const PolicyTraits& traits) {
  others_[static_cast<std::size_t>(agent)].model.traits = traits;
}

PolicyView OpponentModels::ViewOf(const State& state, AgentId agent) const {
  const Cell cell = state.agents[static_cast<std::size_t>(agent)].cell;
  return {state, game_, agent,
          game_.view_radius == 0 ? BitBoard::All() : VisibleCells(game_, cell)};
}

void OpponentModels::ObserveStep(const SeenState& before, const SeenState& after,
                                 const Foretelling& foretold) {
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    Other& other = others_[static_cast<std::size_t>(agent)];
    if (agent == self_ || !before.state.agents[agent].alive || !InView(after, agent)) continue;
    if (other.model.kind != ModelledAgent::Kind::kPolicy && !other.chooses) continue;
    if (InView(before, agent)) {
      ObserveAgent(agent, before.state, after.state, foretold, other);
    } else {
      Reappear(after.state.agents[static_cast<std::size_t>(agent)].cell, other);
    }
  }
}

void OpponentModels::ObserveAgent(AgentId agent, const State& before, const State& after,
                                  const Foretelling& foretold, Other& other) const {
  if (memory_ == ModelMemory::kInferred) InferOrders(agent, before, after, other);
  const PolicyView view = ViewOf(before, agent);
  if (other.chooses) {
    other.choice.Observe(view, other.model.traits, after, ForetoldOf(foretold, self_, agent));
    other.model.kind = other.choice.prefers_prediction() ? ModelledAgent::Kind::kPredicted
                                                         : ModelledAgent::Kind::kPolicy;
    other.model.policy = other.choice.best().policy;
    other.model.memory = other.choice.best().memory;
  } else {
    TakeIn(memory_, other.model.policy, view, after, other.model.traits, other.model.memory,
           other.rng);
  }
}

void OpponentModels::InferOrders(AgentId agent, const State& before, const State& after,
                                 Other& other) const {
  if (other.model.policy != PolicyKind::kSimpleUnbiased) return;
  Action seen = Action::kStop;
  if (SeenAction(before, after, agent, seen)) {
    other.orders.Observe(ViewOf(before, agent), other.model.memory, seen);
  }
  if (after.agents[agent].alive) other.orders.Settle(ViewOf(after, agent));
  other.model.traits = other.orders.traits();
}

void OpponentModels::Reappear(Cell cell, Other& other) const {
  powderkeg::Reappear(memory_, other.model.policy, cell, other.model.memory);
  other.choice.Reappear(cell);
  if (other.chooses) other.model.memory = other.choice.best().memory;
}

}  // namespace powderkeg

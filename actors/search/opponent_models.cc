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
    case OpponentModel::kRawNetwork: break;
  }
  return PolicyKind::kSimpleUnbiased;
}

}  // namespace

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
    other.model.kind = assumed == OpponentModel::kRawNetwork ? ModelledAgent::Kind::kNetwork
                                                             : ModelledAgent::Kind::kPolicy;
    other.model.policy = PolicyOf(assumed);
    other.model.traits = PolicyTraits::Draw(rng);
    other.chooses = assumed == OpponentModel::kObserved;
    other.choice.Start(memory_, rng.Split(kAgentCount + id));
    other.rng = rng.Split(2 * kAgentCount + id);
    other.orders.Start(other.model.traits, rng.Split(id));
  }
}

void OpponentModels::KnowTraits(AgentId agent, const PolicyTraits& traits) {
  others_[static_cast<std::size_t>(agent)].model.traits = traits;
}

void OpponentModels::ObserveStep(const State& before, const State& after) {
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    const auto id = static_cast<std::size_t>(agent);
    if (agent == self_ || !before.agents[id].alive) continue;
    if (others_[id].model.kind == ModelledAgent::Kind::kNetwork) continue;
    const BitBoard visible =
        game_.view_radius == 0 ? BitBoard::All() : VisibleCells(game_, before.agents[id].cell);
    ObserveAgent({before, game_, agent, visible}, after, others_[id]);
  }
}

void OpponentModels::ObserveAgent(const PolicyView& view, const State& after, Other& other) const {
  ModelledAgent& model = other.model;
  Action seen = Action::kStop;
  if (memory_ == ModelMemory::kInferred && model.policy == PolicyKind::kSimpleUnbiased &&
      SeenAction(view.state, after, view.self, seen)) {
    other.orders.Observe(view, model.memory, seen);
    model.traits = other.orders.traits();
  }
  if (other.chooses) {
    other.choice.Observe(view, model.traits, after);
    model.policy = other.choice.best().policy;
    model.memory = other.choice.best().memory;
  } else {
    TakeIn(memory_, model.policy, view, after, model.traits, model.memory, other.rng);
  }
}

}  // namespace powderkeg

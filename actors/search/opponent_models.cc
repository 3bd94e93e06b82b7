#include "actors/search/opponent_models.h"

#include "common/base/check.h"
#include "common/pommerman/observation.h"

namespace powderkeg {

PolicyKind PolicyOf(OpponentModel model) {
  switch (model) {
    case OpponentModel::kIdle: return PolicyKind::kIdle;
    case OpponentModel::kRandom: return PolicyKind::kRandom;
    case OpponentModel::kHarmless: return PolicyKind::kHarmless;
    case OpponentModel::kSimpleUnbiased: return PolicyKind::kSimpleUnbiased;
    case OpponentModel::kOfficialSimple: return PolicyKind::kOfficialSimple;
    case OpponentModel::kRawNetwork: break;
  }
  CHECK(false, "not a rule-based model: ", static_cast<int>(model));
  return PolicyKind::kIdle;
}

void OpponentModels::StartGame(const SearchSettings& settings, const GameSettings& game,
                               AgentId self, Rng rng) {
  memory_ = settings.memory;
  game_ = game;
  self_ = self;
  agents_ = {};
  for (int i = 1; i < kAgentCount; ++i) {
    const auto id = static_cast<std::size_t>((self + i) % kAgentCount);
    agents_[id].model = settings.opponents[static_cast<std::size_t>(i - 1)];
    agents_[id].traits = PolicyTraits::Draw(rng);
    orders_[id].Start(agents_[id].traits, rng.Split(id));
  }
}

void OpponentModels::ObserveStep(const State& before, const State& after) {
  if (memory_ == ModelMemory::kReset) return;
  for (AgentId id = 0; id < kAgentCount; ++id) {
    const auto index = static_cast<std::size_t>(id);
    ModelledAgent& agent = agents_[index];
    if (id == self_ || agent.model == OpponentModel::kRawNetwork) continue;
    if (!before.agents[index].alive) continue;
    InferOrders(before, after, id);
    ObserveMove(PolicyOf(agent.model), before.agents[index].cell, after.agents[index].cell,
                agent.memory);
  }
}

void OpponentModels::InferOrders(const State& before, const State& after, AgentId agent) {
  const auto index = static_cast<std::size_t>(agent);
  ModelledAgent& modelled = agents_[index];
  if (memory_ != ModelMemory::kInferred || modelled.model != OpponentModel::kSimpleUnbiased) return;
  Action seen = Action::kStop;
  if (!SeenAction(before, after, agent, seen)) return;
  const BitBoard visible =
      game_.view_radius == 0 ? BitBoard::All() : VisibleCells(game_, before.agents[index].cell);
  orders_[index].Observe({before, game_, agent, visible}, modelled.memory, seen);
  modelled.traits = orders_[index].traits();
}

}  // namespace powderkeg

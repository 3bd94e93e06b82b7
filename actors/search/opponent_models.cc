#include "actors/search/opponent_models.h"

#include "common/base/check.h"

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
  rng_ = rng;
  agents_ = {};
  for (int i = 1; i < kAgentCount; ++i) {
    ModelledAgent& agent = agents_[static_cast<std::size_t>((self + i) % kAgentCount)];
    agent.model = settings.opponents[static_cast<std::size_t>(i - 1)];
    agent.traits = PolicyTraits::Draw(rng_);
  }
}

void OpponentModels::ObserveStep(const State& before, const State& after) {
  if (memory_ == ModelMemory::kReset) return;
  for (std::size_t id = 0; id < kAgentCount; ++id) {
    ModelledAgent& agent = agents_[id];
    if (static_cast<AgentId>(id) == self_ || agent.model == OpponentModel::kRawNetwork) continue;
    if (!before.agents[id].alive) continue;
    ObserveMove(PolicyOf(agent.model), before.agents[id].cell, after.agents[id].cell, agent.memory);
  }
}

}  // namespace powderkeg

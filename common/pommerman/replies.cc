#include "common/pommerman/replies.h"

namespace powderkeg {

AgentSet LivingEnemies(Mode mode, const State& state, AgentId self) {
  unsigned enemies = 0;
  for (AgentId id = 0; id < kAgentCount; ++id) {
    if (AreEnemies(mode, self, id) && state.agents[id].alive) enemies |= 1U << id;
  }
  return static_cast<AgentSet>(enemies);
}

Replies RepliesTo(const State& state, AgentId self, AgentSet repliers, int near) {
  Replies replies;
  int found = 0;
  for (int distance = 1; distance <= near; ++distance) {
    for (AgentId id = 0; id < kAgentCount && found < Replies::kRepliers; ++id) {
      if (!Has(repliers, static_cast<std::size_t>(id))) continue;
      if (ManhattanDistance(state.agents[id].cell, state.agents[self].cell) != distance) continue;
      ++found;
      const ActionSet legal = LegalActions(state, id);
      for (std::size_t action = 1; action < kActionCount; ++action) {
        if (!Has(legal, action)) continue;
        replies.actions[replies.count++][id] = static_cast<Action>(action);
      }
    }
  }
  return replies;
}

bool LayBombs(AgentId self, AgentSet layers, int near, State& state) {
  bool laid = false;
  for (AgentId id = 0; id < kAgentCount; ++id) {
    const AgentState& agent = state.agents[id];
    if (!Has(layers, static_cast<std::size_t>(id)) || !agent.alive || agent.ammo == 0) continue;
    if (state.bomb_cells.Has(agent.cell) || state.bomb_count == kMaxBombs) continue;
    if (ManhattanDistance(agent.cell, state.agents[self].cell) > near) continue;
    Bomb bomb{.cell = agent.cell, .life = kFreshBombLife, .blast_strength = agent.blast_strength};
    bomb.set_owner(id);
    state.AddBomb(bomb);
    laid = true;
  }
  return laid;
}

}  // namespace powderkeg

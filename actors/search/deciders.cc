#include "actors/search/deciders.h"

namespace powderkeg {
namespace {

// Whether a bomb laid on `from` with this blast strength would burn `target` on the present board.
bool BlastReaches(const State& state, Cell from, int blast_strength, Cell target) {
  for (const Direction direction : kDirections) {
    Cell cell = from;
    for (int reach = 1; reach < blast_strength; ++reach) {
      cell = Neighbour(cell, direction);
      if (cell == kNoCell || state.rigid.Has(cell)) break;
      if (cell == target) return true;
      if (state.wood.Has(cell)) break;
    }
  }
  return from == target;
}

}  // namespace

AgentId DeciderAfter(const SearchSettings& settings, const GameSettings& game, const State& state,
                     AgentId self) {
  if (settings.tree == TreeKind::kOnePlayer) return self;
  constexpr int kDangerBonus = 2 * kBoardSize;  // more than any distance
  const Cell own_cell = state.agents[static_cast<std::size_t>(self)].cell;
  AgentId chosen = self;
  int lowest_cost = settings.simulated_opponent_reach + 1;
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    const AgentState& other = state.agents[static_cast<std::size_t>(agent)];
    if (!other.alive || !AreEnemies(game.mode, self, agent)) continue;
    int cost = ManhattanDistance(own_cell, other.cell);
    if (cost > settings.simulated_opponent_reach) continue;
    if (settings.simulated_opponent == SimulatedOpponent::kMostDangerous && other.ammo > 0 &&
        BlastReaches(state, other.cell, other.blast_strength, own_cell)) {
      cost -= kDangerBonus;
    }
    if (cost < lowest_cost) {
      lowest_cost = cost;
      chosen = agent;
    }
  }
  return chosen;
}

}  // namespace powderkeg

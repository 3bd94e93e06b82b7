#include "actors/play/step_events.h"

#include "common/pommerman/blast.h"
#include "common/pommerman/step.h"

namespace powderkeg {
namespace {

// Beyond the end of the step.
constexpr std::int8_t kLongLife = 100;

constexpr AgentSet Only(AgentId agent) { return static_cast<AgentSet>(1 << agent); }
constexpr void Insert(AgentId agent, AgentSet& set) { set |= Only(agent); }

// The position after the step if nothing exploded: its bombs are those of `before`, in order, then
// those just laid, all where they went. Flames do not stand in anybody's way, and nobody can pick
// up what lies in them.
State WithoutExplosions(const GameSettings& settings, const State& before,
                        const JointAction& actions) {
  State calm = before;
  calm.RemoveItems(before.flames[1] | before.flames[2]);
  calm.flames = {};
  for (Bomb& bomb : calm.Bombs()) bomb.life = kLongLife;
  Step(settings, actions, calm);
  return calm;
}

// The living agent whose next cell in `direction` is `target`, or -1.
AgentId AgentBehind(const State& state, Cell target, Direction direction) {
  for (AgentId id = 0; id < kAgentCount; ++id) {
    const AgentState& agent = state.agents[id];
    if (agent.alive && Neighbour(agent.cell, direction) == target) return id;
  }
  return -1;
}

AgentSet Layers(const State& before, const State& calm) {
  AgentSet layers = 0;
  for (int i = before.bomb_count; i < calm.bomb_count; ++i) Insert(calm.bombs[i].owner(), layers);
  return layers;
}

// Nothing but a kick gives a bomb a new direction, and the kicker then stands right behind it.
AgentSet Kickers(const State& before, const State& calm) {
  AgentSet kickers = 0;
  for (int i = 0; i < calm.bomb_count; ++i) {
    const Direction direction = calm.bombs[i].direction();
    const Direction earlier =
        i < before.bomb_count ? before.bombs[i].direction() : Direction::kNone;
    if (direction == Direction::kNone || direction == earlier) continue;
    const AgentId kicker = AgentBehind(calm, calm.bombs[i].cell, direction);
    if (kicker >= 0) Insert(kicker, kickers);
  }
  return kickers;
}

// The cells that the bombs of each agent burnt: those that are gone from `after`.
std::array<BitBoard, kAgentCount> Blasts(const State& calm, const State& after) {
  std::array<BitBoard, kAgentCount> blasts;
  for (const Bomb& bomb : calm.Bombs()) {
    if (after.bomb_cells.Has(bomb.cell)) continue;
    blasts[bomb.owner()] |= BlastCells(bomb.cell, bomb.blast_strength, calm.rigid, calm.wood);
  }
  return blasts;
}

}  // namespace

StepEvents StepWatcher::Watch(const GameSettings& settings, const State& before,
                              const JointAction& actions, const State& after) {
  const State calm = WithoutExplosions(settings, before, actions);
  const std::array<BitBoard, kAgentCount> blasts = Blasts(calm, after);
  StepEvents events{.laid = Layers(before, calm), .kicked = Kickers(before, calm)};
  for (AgentId owner = 0; owner < kAgentCount; ++owner) {
    auto& flames = flames_[owner];
    flames = {flames[1], flames[2], blasts[owner]};
    const BitBoard burning = flames[0] | flames[1] | flames[2];
    for (AgentId id = 0; id < kAgentCount; ++id) {
      if (!before.agents[id].alive || after.agents[id].alive) continue;
      Insert(id, events.burnt);
      if (burning.Has(after.agents[id].cell)) Insert(owner, events.killers[id]);
    }
  }
  return events;
}

}  // namespace powderkeg

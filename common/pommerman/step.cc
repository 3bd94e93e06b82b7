#include "common/pommerman/step.h"

#include <algorithm>

#include "common/pommerman/blast.h"
#include "common/pommerman/movement.h"

namespace powderkeg {
namespace {

constexpr std::uint8_t IncreasedUpTo(int cap, int value) {
  return static_cast<std::uint8_t>(std::min(value + 1, cap));
}

// 3.1. An item comes out with the first flame to die; where another flame remains it is lost.
void AgeFlames(State& state) {
  const BitBoard died = state.flames[0];
  state.flames = {state.flames[1], state.flames[2], BitBoard()};
  state.RemoveItems(died & state.Flames());
}

// 3.2, for those who want to lay a bomb. The list is never full in positions that play can reach.
void LayBombs(const JointAction& actions, State& state) {
  for (AgentId id = 0; id < kAgentCount; ++id) {
    AgentState& agent = state.agents[id];
    if (actions[id] != Action::kBomb || !agent.alive || agent.ammo == 0 ||
        state.bomb_cells.Has(agent.cell) || state.bomb_count == kMaxBombs) {
      continue;
    }
    --agent.ammo;
    Bomb bomb{.cell = agent.cell,
              .life = kFreshBombLife + 1,  // it ticks in the same step
              .blast_strength = agent.blast_strength};
    bomb.set_owner(id);
    state.AddBomb(bomb);
  }
}

void PickUp(const GameSettings& settings, Item item, AgentState& agent) {
  switch (item) {
    case Item::kExtraBomb: agent.ammo = IncreasedUpTo(kMaxAmmo, agent.ammo); break;
    case Item::kIncreaseRange:
      agent.blast_strength = IncreasedUpTo(settings.blast_strength_cap, agent.blast_strength);
      break;
    case Item::kKick: agent.can_kick = true; break;
    case Item::kNone: break;
  }
}

// 3.8, second half. Visible items and resting agents never share a cell, so whoever stands on one
// has just come.
void PickUpItems(const GameSettings& settings, BitBoard agent_cells, State& state) {
  const BitBoard picked = agent_cells & state.VisibleItems();
  if (picked.Empty()) return;
  for (AgentState& agent : state.agents) {
    if (agent.alive && picked.Has(agent.cell)) PickUp(settings, state.ItemAt(agent.cell), agent);
  }
  state.RemoveItems(picked);
}

// 3.9. Returns the cells of the bombs that explode by themselves.
BitBoard TickBombs(State& state) {
  BitBoard due = state.bomb_cells & state.Flames();
  for (Bomb& bomb : state.Bombs()) {
    if (--bomb.life == 0) due.Add(bomb.cell);
  }
  return due;
}

void ReturnAmmo(const Bomb& bomb, State& state) {
  AgentState& owner = state.agents[bomb.owner()];
  owner.ammo = IncreasedUpTo(kMaxAmmo, owner.ammo);
}

// 3.10. Explodes the bombs on these cells and, round by round, those that they reach. Returns all
// burning cells.
BitBoard ExplodeBombs(BitBoard due, State& state) {
  BitBoard exploded;
  BitBoard burning;
  while (due.Any()) {
    exploded |= due;
    for (const Bomb& bomb : state.Bombs()) {
      if (!due.Has(bomb.cell)) continue;
      ReturnAmmo(bomb, state);
      burning |= BlastCells(bomb.cell, bomb.blast_strength, state.rigid, state.wood);
    }
    due = state.bomb_cells & burning & ~exploded;
  }
  state.RemoveBombs(exploded);
  return burning;
}

// 3.11 for the cells: flames destroy visible items and lay bare, once they are gone, hidden ones.
void Burn(BitBoard burning, State& state) {
  state.RemoveItems(burning & state.VisibleItems());
  state.wood &= ~burning;
  state.flames[2] = burning;
}

// 3.11 for the agents.
void KillAgentsInFlames(BitBoard agent_cells, State& state) {
  const BitBoard flames = state.Flames();
  if ((flames & agent_cells).Empty()) return;
  for (AgentState& agent : state.agents) agent.alive = agent.alive && !flames.Has(agent.cell);
}

}  // namespace

void Step(const GameSettings& settings, const JointAction& actions, State& state) {
  AgeFlames(state);
  LayBombs(actions, state);
  const BitBoard agent_cells = MoveAgentsAndBombs(actions, state);
  PickUpItems(settings, agent_cells, state);
  const BitBoard due = TickBombs(state);
  if (due.Any()) Burn(ExplodeBombs(due, state), state);
  KillAgentsInFlames(agent_cells, state);
  state.messages = {};
  ++state.step;
}

void Step(const GameSettings& settings, const JointAction& actions,
          const std::array<Message, kAgentCount>& messages, State& state) {
  std::array<Message, kAgentCount> sent{};
  for (AgentId id = 0; id < kAgentCount; ++id) {
    if (state.agents[id].alive) sent[id] = messages[id];
  }
  Step(settings, actions, state);
  state.messages = sent;
}

namespace {

// The cells at this distance from the border of a board of this size.
BitBoard Ring(int board_size, int distance) {
  const int last = board_size - 1 - distance;
  BitBoard ring;
  for (int i = distance; i <= last; ++i) {
    ring.Add(CellAt(distance, i));
    ring.Add(CellAt(last, i));
    ring.Add(CellAt(i, distance));
    ring.Add(CellAt(i, last));
  }
  return ring;
}

void CollapseRing(BitBoard ring, State& state) {
  for (AgentState& agent : state.agents) agent.alive = agent.alive && !ring.Has(agent.cell);
  for (const Bomb& bomb : state.Bombs()) {
    if (ring.Has(bomb.cell)) ReturnAmmo(bomb, state);
  }
  state.RemoveBombs(ring);
  state.RemoveItems(ring);
  state.wood &= ~ring;
  for (BitBoard& flames : state.flames) flames &= ~ring;
  state.rigid |= ring;
}

// Seats in play, one bit each.
constexpr std::uint8_t kAllSeats = 0b1111;
constexpr std::uint8_t kTwoSeats = 0b0011;
constexpr std::uint8_t kEvenTeam = 0b0101;
constexpr std::uint8_t kOddTeam = 0b1010;

std::uint8_t LivingSeats(const State& state) {
  std::uint8_t living = 0;
  for (AgentId id = 0; id < kAgentCount; ++id) {
    if (state.agents[id].alive) living = static_cast<std::uint8_t>(living | 1 << id);
  }
  return living;
}

// The seats that have won by being the only side left; 0 where that is no single side.
std::uint8_t SoleSide(const GameSettings& settings, std::uint8_t living) {
  if (IsTeamMode(settings.mode)) {
    if (living == 0) return 0;
    if ((living & kOddTeam) == 0) return kEvenTeam;
    if ((living & kEvenTeam) == 0) return kOddTeam;
    return 0;
  }
  return std::has_single_bit(living) ? living : std::uint8_t{0};
}

// The reward of a seat while no side is left alone.
std::int8_t OpenReward(const GameSettings& settings, bool time_is_up, std::uint8_t living,
                       bool alive) {
  if (time_is_up) return -1;
  if (IsTeamMode(settings.mode)) return living == 0 ? -1 : 0;
  if (settings.mode == Mode::kOneVsOne) return 0;
  return alive ? 0 : -1;
}

}  // namespace

void Collapse(const GameSettings& settings, State& state) {
  for (int ring = 0; ring < static_cast<int>(settings.collapse_steps.size()); ++ring) {
    if (settings.collapse_steps[ring] != 0 && settings.collapse_steps[ring] == state.step) {
      CollapseRing(Ring(settings.board_size, ring), state);
    }
  }
}

Outcome OutcomeOf(const GameSettings& settings, const State& state) {
  const std::uint8_t living = LivingSeats(state);
  const std::uint8_t seats = settings.mode == Mode::kOneVsOne ? kTwoSeats : kAllSeats;
  const bool time_is_up = state.step >= settings.max_steps;
  Outcome outcome;
  outcome.winners = SoleSide(settings, living);
  outcome.done = outcome.winners != 0 || living == 0 || time_is_up;
  if (outcome.done) outcome.result = outcome.winners != 0 ? Result::kWin : Result::kTie;
  for (AgentId id = 0; id < kAgentCount; ++id) {
    if (!Has(seats, id)) continue;
    const bool wins = outcome.Won(id);
    outcome.rewards[id] = outcome.winners != 0
                              ? static_cast<std::int8_t>(wins ? 1 : -1)
                              : OpenReward(settings, time_is_up, living, Has(living, id));
  }
  return outcome;
}

ActionSet LegalActions(const State& state, AgentId agent) {
  const AgentState& self = state.agents[agent];
  BitBoard open = ~(state.rigid | state.wood | state.flames[1] | state.flames[2]);
  if (!self.can_kick) open &= ~state.bomb_cells;
  for (const AgentState& other : state.agents) {
    if (other.alive) open.Remove(other.cell);
  }
  int legal = 1 << static_cast<int>(Action::kStop);
  for (const Direction direction : kDirections) {
    const Cell target = NeighbourOrSelf(self.cell, direction);
    legal |= static_cast<int>(open.Has(target)) << static_cast<int>(direction);
  }
  if (self.ammo > 0 && !state.bomb_cells.Has(self.cell)) {
    legal |= 1 << static_cast<int>(Action::kBomb);
  }
  return static_cast<ActionSet>(legal);
}

}  // namespace powderkeg

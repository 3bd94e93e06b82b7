#include "common/pommerman/movement.h"

#include <cstdint>

namespace powderkeg {
namespace {

constexpr int kNobody = -1;

// The cell that everybody wants to be on after the step; one's own to stay. Entries of dead agents
// and beyond the last bomb are meaningless.
struct Wishes {
  std::array<std::uint8_t, kAgentCount> agents;
  std::array<std::uint8_t, kMaxBombs> bombs;
};

// 3.2 for moves: walls and the edge are the only obstacles to a wish.
std::uint8_t AgentWish(const AgentState& agent, Action action, BitBoard walls) {
  const Cell target = TargetOf(agent.cell, action);
  return walls.Has(target) ? agent.cell : static_cast<std::uint8_t>(target);
}

// 3.3. `obstacles` are walls and visible items.
std::uint8_t BombWish(const Bomb& bomb, BitBoard obstacles) {
  const Cell target = NeighbourOrSelf(bomb.cell, bomb.direction());
  return obstacles.Has(target) ? bomb.cell : static_cast<std::uint8_t>(target);
}

// How many want a cell, as exactly as the rules ask: nobody, one, more. Leaving never counts down.
class WishCount {
 public:
  void Add(Cell cell) {
    if (any_.Has(cell)) many_.Add(cell);
    any_.Add(cell);
  }
  void Clear(Cell cell) {
    any_.Remove(cell);
    many_.Remove(cell);
  }
  [[nodiscard]] bool Any(Cell cell) const { return any_.Has(cell); }
  [[nodiscard]] bool Many(Cell cell) const { return many_.Has(cell); }

 private:
  BitBoard any_;
  BitBoard many_;
};

// Settles wishes that get in each other's way, rules 3.4 to 3.7, one method each. Lives for one
// step.
class Conflicts {
 public:
  Conflicts(const JointAction& actions, BitBoard obstacles, State& state, Wishes& wishes)
      : actions_(actions), obstacles_(obstacles), state_(state), wishes_(wishes) {
    kicker_.fill(kNobody);
    kicked_.fill(kNobody);
  }

  void Settle() {
    BounceCrossings();
    BounceSharedTargets();
    if (KickAndMeet()) UndoLate();
  }

  // Whether the bomb is kicked by an agent in this step.
  [[nodiscard]] bool Kicked(int bomb) const { return kicker_[bomb] != kNobody; }

 private:
  [[nodiscard]] const AgentState& Agent(AgentId id) const { return state_.agents[id]; }
  [[nodiscard]] const Bomb& BombOf(int index) const { return state_.bombs[index]; }
  [[nodiscard]] bool Leaves(AgentId id) const { return wishes_.agents[id] != Agent(id).cell; }
  [[nodiscard]] bool Rolls(int bomb) const { return wishes_.bombs[bomb] != BombOf(bomb).cell; }

  template <typename Visit>
  void ForEachLivingAgent(Visit&& visit) const {
    for (AgentId id = 0; id < kAgentCount; ++id) {
      if (Agent(id).alive) visit(id);
    }
  }

  void SetAgentWish(AgentId id, std::uint8_t cell) {
    wishes_.agents[id] = cell;
    agents_wanting_.Add(cell);
  }
  void SetBombWish(int bomb, std::uint8_t cell) {
    wishes_.bombs[bomb] = cell;
    bombs_wanting_.Add(cell);
  }
  void SendBackAgent(AgentId id) { SetAgentWish(id, Agent(id).cell); }
  void SendBackBomb(int bomb) { SetBombWish(bomb, BombOf(bomb).cell); }

  // The living agent that now wants this cell. There is at most one once 3.5 is done.
  [[nodiscard]] AgentId AgentWanting(Cell cell) const {
    for (AgentId id = 0; id < kAgentCount; ++id) {
      if (Agent(id).alive && wishes_.agents[id] == cell) return id;
    }
    return kNobody;
  }

  void BounceCrossings();
  void BounceSharedTargets();
  bool BounceAgentsOnce();
  bool BounceBombsOnce();
  bool KickAndMeet();
  [[nodiscard]] Cell KickTarget(AgentId id) const;
  void Kick(AgentId id, int bomb);
  void Unlink(AgentId id, int bomb);
  void UndoLate();
  bool UndoAgentsOnce();
  bool UndoBombsOnce();

  const JointAction& actions_;
  const BitBoard obstacles_;  // no bomb rolls here: walls and visible items
  State& state_;
  Wishes& wishes_;
  WishCount agents_wanting_;                     // A in the rules
  WishCount bombs_wanting_;                      // B in the rules
  std::array<std::int8_t, kMaxBombs> kicker_;    // the agent linked to a bomb
  std::array<std::int8_t, kAgentCount> kicked_;  // the bomb linked to an agent
};

// Whether a move crosses the same cell border as another, in either direction.
bool SameBorder(Cell from, Cell to, Cell other_from, Cell other_to) {
  return (from == other_from && to == other_to) || (from == other_to && to == other_from);
}

// 3.4. All are judged by the wishes they came with: nobody but the other side of a swap can be
// affected by a bounce.
void Conflicts::BounceCrossings() {
  const Wishes original = wishes_;
  ForEachLivingAgent([&](AgentId id) {
    ForEachLivingAgent([&](AgentId other) {
      if (id != other && Leaves(id) && original.agents[id] == Agent(other).cell &&
          original.agents[other] == Agent(id).cell) {
        wishes_.agents[id] = Agent(id).cell;
      }
    });
  });
  for (int bomb = 0; bomb < state_.bomb_count; ++bomb) {
    const Cell from = BombOf(bomb).cell;
    const Cell to = original.bombs[bomb];
    if (from == to) continue;
    bool crosses = false;
    ForEachLivingAgent(
        [&](AgentId id) { crosses |= SameBorder(from, to, Agent(id).cell, original.agents[id]); });
    for (int other = 0; other < state_.bomb_count; ++other) {
      crosses |= BombOf(other).cell == to && original.bombs[other] == from;
    }
    if (crosses) wishes_.bombs[bomb] = BombOf(bomb).cell;
  }
}

// 3.5.
void Conflicts::BounceSharedTargets() {
  ForEachLivingAgent([&](AgentId id) { agents_wanting_.Add(wishes_.agents[id]); });
  for (int bomb = 0; bomb < state_.bomb_count; ++bomb) bombs_wanting_.Add(wishes_.bombs[bomb]);
  bool changed = true;
  while (changed) {
    changed = BounceAgentsOnce();
    changed |= BounceBombsOnce();
  }
}

bool Conflicts::BounceAgentsOnce() {
  bool changed = false;
  ForEachLivingAgent([&](AgentId id) {
    const Cell wish = wishes_.agents[id];
    if (!Leaves(id) || !(agents_wanting_.Many(wish) || bombs_wanting_.Many(wish))) return;
    SendBackAgent(id);
    changed = true;
  });
  return changed;
}

bool Conflicts::BounceBombsOnce() {
  bool changed = false;
  for (int bomb = 0; bomb < state_.bomb_count; ++bomb) {
    const Cell wish = wishes_.bombs[bomb];
    if (!Rolls(bomb) || !(bombs_wanting_.Many(wish) || agents_wanting_.Many(wish))) continue;
    SendBackBomb(bomb);
    changed = true;
  }
  return changed;
}

// 3.6. Decides for every bomb by the wishes that 3.5 left and applies the decisions afterwards,
// bombs first. Returns whether there was any.
bool Conflicts::KickAndMeet() {
  std::array<std::uint8_t, kMaxBombs> decided;
  std::array<int, kMaxBombs> changed_bombs;
  std::array<AgentId, kAgentCount> returning_agents;
  int changed_count = 0;
  int returning_count = 0;
  for (int bomb = 0; bomb < state_.bomb_count; ++bomb) {
    const Cell wish = wishes_.bombs[bomb];
    const AgentId id = agents_wanting_.Any(wish) ? AgentWanting(wish) : kNobody;
    if (id == kNobody || (!Leaves(id) && !Rolls(bomb))) continue;
    changed_bombs[changed_count++] = bomb;
    decided[bomb] = BombOf(bomb).cell;
    if (!Leaves(id)) continue;
    if (const Cell target = KickTarget(id); target != kNoCell) {
      decided[bomb] = static_cast<std::uint8_t>(target);
      Kick(id, bomb);
    } else {
      returning_agents[returning_count++] = id;
    }
  }
  for (int i = 0; i < changed_count; ++i) SetBombWish(changed_bombs[i], decided[changed_bombs[i]]);
  for (int i = 0; i < returning_count; ++i) SendBackAgent(returning_agents[i]);
  return changed_count > 0;
}

// Where a bomb goes that the agent would kick by moving to its wish, or kNoCell. A cell that
// anybody ever wished for in this step is taken.
Cell Conflicts::KickTarget(AgentId id) const {
  const Cell wish = wishes_.agents[id];
  const Cell target = NeighbourOrSelf(wish, DirectionOf(actions_[id]));
  const bool free = target != wish && !agents_wanting_.Any(target) && !bombs_wanting_.Any(target) &&
                    !obstacles_.Has(target);
  return Agent(id).can_kick && free ? target : kNoCell;
}

// Links them and turns the bomb; its old wish is nobody's from here on.
void Conflicts::Kick(AgentId id, int bomb) {
  bombs_wanting_.Clear(wishes_.bombs[bomb]);
  state_.bombs[bomb].set_direction(DirectionOf(actions_[id]));
  kicker_[bomb] = static_cast<std::int8_t>(id);
  kicked_[id] = static_cast<std::int8_t>(bomb);
}

void Conflicts::Unlink(AgentId id, int bomb) {
  kicker_[bomb] = kNobody;
  kicked_[id] = kNobody;
}

// 3.7.
void Conflicts::UndoLate() {
  bool changed = true;
  while (changed) {
    changed = UndoAgentsOnce();
    changed |= UndoBombsOnce();
  }
}

bool Conflicts::UndoAgentsOnce() {
  bool changed = false;
  ForEachLivingAgent([&](AgentId id) {
    const Cell wish = wishes_.agents[id];
    if (!Leaves(id) || !(agents_wanting_.Many(wish) || bombs_wanting_.Any(wish))) return;
    if (const int bomb = kicked_[id]; bomb != kNobody) {
      SendBackBomb(bomb);
      Unlink(id, bomb);
    }
    SendBackAgent(id);
    changed = true;
  });
  return changed;
}

bool Conflicts::UndoBombsOnce() {
  bool changed = false;
  for (int bomb = 0; bomb < state_.bomb_count; ++bomb) {
    const Cell wish = wishes_.bombs[bomb];
    if (!Rolls(bomb) && !Kicked(bomb)) continue;
    if (!(bombs_wanting_.Many(wish) || agents_wanting_.Any(wish))) continue;
    SendBackBomb(bomb);
    if (const AgentId id = kicker_[bomb]; id != kNobody) {
      SendBackAgent(id);
      Unlink(id, bomb);
    }
    changed = true;
  }
  return changed;
}

// Tells whether anybody can get in anybody's way: a mover aims at a cell that another mover aims at
// or that is held by whoever stands or lies there before the step. Without such a meeting rules 3.4
// to 3.7 change nothing.
class Claims {
 public:
  explicit Claims(BitBoard held) : claimed_(held) {}
  void Add(Cell from, Cell to) {
    contested_ |= from != to && claimed_.Has(to);
    claimed_.Add(to);
  }
  [[nodiscard]] bool contested() const { return contested_; }

 private:
  BitBoard claimed_;
  bool contested_ = false;
};

// 3.2 and 3.3. Returns whether the wishes are contested.
bool MakeWishes(const JointAction& actions, const State& state, BitBoard obstacles,
                Wishes& wishes) {
  const BitBoard walls = state.rigid | state.wood;
  Claims claims(state.AgentCells() | state.bomb_cells);
  for (AgentId id = 0; id < kAgentCount; ++id) {
    const AgentState& agent = state.agents[id];
    if (!agent.alive) continue;
    wishes.agents[id] = AgentWish(agent, actions[id], walls);
    claims.Add(agent.cell, wishes.agents[id]);
  }
  for (int bomb = 0; bomb < state.bomb_count; ++bomb) {
    wishes.bombs[bomb] = BombWish(state.bombs[bomb], obstacles);
    claims.Add(state.bombs[bomb].cell, wishes.bombs[bomb]);
  }
  return claims.contested();
}

// 3.8 for agents. Returns the cells of the living.
BitBoard CommitAgents(const Wishes& wishes, State& state) {
  BitBoard cells;
  for (AgentId id = 0; id < kAgentCount; ++id) {
    AgentState& agent = state.agents[id];
    if (!agent.alive) continue;
    agent.cell = wishes.agents[id];
    cells.Add(agent.cell);
  }
  return cells;
}

// 3.8 for bombs: one that keeps its cell without having been kicked is at rest for good.
template <typename Kicked>
void CommitBombs(const Wishes& wishes, Kicked kicked, State& state) {
  state.bomb_cells = BitBoard();
  for (int index = 0; index < state.bomb_count; ++index) {
    Bomb& bomb = state.bombs[index];
    if (wishes.bombs[index] == bomb.cell && !kicked(index)) bomb.set_direction(Direction::kNone);
    bomb.cell = wishes.bombs[index];
    state.bomb_cells.Add(bomb.cell);
  }
}

}  // namespace

BitBoard MoveAgentsAndBombs(const JointAction& actions, State& state) {
  const BitBoard obstacles = state.rigid | state.wood | state.VisibleItems();
  Wishes wishes;
  if (MakeWishes(actions, state, obstacles, wishes)) {
    Conflicts conflicts(actions, obstacles, state, wishes);
    conflicts.Settle();
    CommitBombs(
        wishes, [&](int bomb) { return conflicts.Kicked(bomb); }, state);
  } else {
    CommitBombs(
        wishes, [](int) { return false; }, state);
  }
  return CommitAgents(wishes, state);
}

}  // namespace powderkeg

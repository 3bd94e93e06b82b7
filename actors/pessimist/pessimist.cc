#include "actors/pessimist/pessimist.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace powderkeg {
namespace {

constexpr int kDeath = 100'000;
constexpr int kDoom = 50'000;

bool HasAction(ActionSet set, Action action) { return Has(set, static_cast<std::size_t>(action)); }

// 64 log2(number), linear between powers of two.
int Logarithm(unsigned number) {
  const int power = std::bit_width(number) - 1;
  return 64 * power + static_cast<int>(((number - (1U << power)) << 6) >> power);
}

CellsByStep Union(CellsByStep a, const CellsByStep& b) {
  for (std::size_t step = 0; step < a.size(); ++step) a[step] |= b[step];
  return a;
}

}  // namespace

bool FutureMemory::Fits(const Entry& entry, const State& state) {
  return entry.bomb_count == state.bomb_count && entry.step == state.step &&
         std::equal(entry.bombs.begin(), entry.bombs.begin() + entry.bomb_count,
                    state.bombs.begin()) &&
         entry.wood == state.wood && entry.items == state.VisibleItems();
}

const BombFuture& FutureMemory::For(const GameSettings& settings, const State& state) {
  const std::size_t kept = std::min(count_, kSize);
  for (std::size_t i = 0; i < kept; ++i) {
    if (Fits(entries_[i], state)) return entries_[i].future;
  }
  Entry& entry = entries_[count_++ % kSize];
  entry.bombs = state.bombs;
  entry.bomb_count = state.bomb_count;
  entry.step = state.step;
  entry.wood = state.wood;
  entry.items = state.VisibleItems();
  entry.future = ForeseeBombs(settings, state);
  return entry.future;
}

Action Pessimist::Choose(const GameSettings& game, const State& state, AgentId self,
                         BitBoard visible, Rng& rng) {
  game_ = game;
  self_ = self;
  mate_ = TeamMateOf(game.mode, self);
  futures_.Clear();
  LookAround(state, visible);
  AttractBy(state);
  const Replies replies = RepliesTo(state, visible);
  depth_ = replies.count > 1 ? settings_.depth : settings_.depth + 1;
  const ActionSet legal = LegalActions(state, self);
  int best = std::numeric_limits<int>::min();
  std::array<Action, kActionCount> bests{};
  std::uint32_t count = 0;
  for (int number = 0; number < kActionCount; ++number) {
    const auto action = static_cast<Action>(number);
    if (!HasAction(legal, action)) continue;
    const int value = ValueOf(state, replies, action);
    if (value > best) count = 0;
    best = std::max(best, value);
    if (value == best) bests[count++] = action;
  }
  return bests[rng.Below(count)];
}

void Pessimist::LookAround(const State& state, BitBoard visible) {
  enemies_ = 0;
  in_the_way_ = 0;
  for (AgentId id = 0; id < kAgentCount; ++id) {
    const AgentState& agent = state.agents[id];
    if (id == self_ || !agent.alive) continue;
    if (AreEnemies(game_.mode, self_, id)) enemies_ |= static_cast<std::uint8_t>(1 << id);
    if (visible.Has(agent.cell)) in_the_way_ |= static_cast<std::uint8_t>(1 << id);
  }
}

void Pessimist::AttractBy(const State& state) {
  attraction_ = {};
  const BombFuture& future = futures_.For(game_, state);
  const AgentState& self = state.agents[self_];
  const BitBoard doomed = state.wood & ~future.wood;
  const BitBoard walls = state.rigid | (state.wood & ~doomed);
  attraction_.Add(state.VisibleItems(), 30);
  if (self.ammo > 0) attraction_.Add((state.wood & ~doomed).Neighbours() & ~walls, 16);
  for (AgentId id = 0; id < kAgentCount; ++id) {
    if (Has(enemies_, static_cast<std::size_t>(id))) {
      attraction_.Add(BitBoard::Of(state.agents[id].cell), 20);
    }
  }
  attraction_.Spread(~(walls | state.bomb_cells) | BitBoard::Of(self.cell));
}

Pessimist::Replies Pessimist::RepliesTo(const State& state, BitBoard visible) const {
  Replies replies;
  replies.actions[replies.count++] = JointAction{};
  int near = 0;
  for (int distance = 1; distance <= settings_.near && near < 2; ++distance) {
    for (AgentId id = 0; id < kAgentCount && near < 2; ++id) {
      const Cell cell = state.agents[id].cell;
      if (!Has(enemies_, static_cast<std::size_t>(id)) || !visible.Has(cell)) continue;
      if (ManhattanDistance(cell, state.agents[self_].cell) != distance) continue;
      ++near;
      const ActionSet legal = LegalActions(state, id);
      for (int number = 1; number < kActionCount; ++number) {
        if (!Has(legal, static_cast<std::size_t>(number))) continue;
        JointAction& joint = replies.actions[replies.count++];
        joint = {};
        joint[id] = static_cast<Action>(number);
      }
    }
  }
  return replies;
}

int Pessimist::ValueOf(const State& state, const Replies& replies, Action action) {
  int worst = std::numeric_limits<int>::max();
  int sum = 0;
  for (int i = 0; i < replies.count; ++i) {
    JointAction joint = replies.actions[i];
    joint[self_] = action;
    State next = state;
    Step(game_, joint, next);
    Collapse(game_, next);
    const int value = Best(next, depth_ - 1);
    worst = std::min(worst, value);
    sum += value;
  }
  const double mean = static_cast<double>(sum) / replies.count;
  return static_cast<int>(settings_.fear * worst + (1 - settings_.fear) * mean);
}

int Pessimist::Best(const State& state, int depth) {
  if (!state.agents[self_].alive) return -kDeath;
  if (depth == 0) return LeafValue(state);
  const ActionSet legal = LegalActions(state, self_);
  int best = std::numeric_limits<int>::min();
  for (int number = 0; number < kActionCount; ++number) {
    if (!Has(legal, static_cast<std::size_t>(number))) continue;
    JointAction joint{};
    joint[self_] = static_cast<Action>(number);
    State next = state;
    Step(game_, joint, next);
    Collapse(game_, next);
    best = std::max(best, Best(next, depth - 1));
  }
  return best;
}

int Pessimist::LeafValue(const State& state) {
  const BombFuture& future = futures_.For(game_, state);
  return Survivabilities(state, future) + Tactics(state, future);
}

int Pessimist::Survivabilities(const State& state, const BombFuture& future) const {
  CellsByStep taken{};
  for (std::size_t id = 0; id < kAgentCount; ++id) {
    if (!Has(in_the_way_, id) || !state.agents[id].alive) continue;
    const bool enemy = Has(enemies_, id);
    CellsByStep reach =
        ReachableCells(future, state.agents[id].cell, enemy ? settings_.spread : 0);
    for (int step = settings_.hold + 1; step <= kForesight; ++step) reach[step] = {};
    taken = Union(taken, reach);
  }
  const Cell cell = state.agents[self_].cell;
  const int own = CountPairs(SurvivableCells(future, cell, taken));
  double value = 0;
  if (own > 0) {
    value -= settings_.own_weight / own;
  } else {
    value -= kDoom - CountPairs(ReachableCells(future, cell, taken));
  }
  CellsByStep ours = ReachableCells(future, cell, settings_.own_spread);
  for (int step = settings_.hold + 1; step <= kForesight; ++step) ours[step] = {};
  for (AgentId id = 0; id < kAgentCount; ++id) {
    const bool enemy = Has(enemies_, static_cast<std::size_t>(id));
    if (id == self_ || !(enemy || id == mate_)) continue;
    int pairs = 0;
    if (state.agents[id].alive) {
      pairs = CountPairs(
          SurvivableCells(future, state.agents[id].cell, enemy ? ours : CellsByStep{}));
    }
    if (enemy) {
      value += settings_.enemy_weight / (pairs + 4) + (pairs == 0 ? settings_.kill : 0) -
               settings_.siege * Logarithm(static_cast<unsigned>(pairs + 4)) / 64 +
               (state.agents[id].alive ? 0 : settings_.kill);
    } else {
      value -= settings_.mate_weight / (pairs + 1) + (pairs == 0 ? kDoom / 5 : 0);
    }
  }
  return static_cast<int>(value);
}

int Pessimist::Tactics(const State& state, const BombFuture& future) const {
  const AgentState& self = state.agents[self_];
  int bombs_out = 0;
  for (const Bomb& bomb : state.Bombs()) bombs_out += bomb.owner() == self_ ? 1 : 0;
  return 60 * std::min(self.ammo + bombs_out, 6) + 30 * std::min<int>(self.blast_strength, 6) +
         (self.can_kick ? 60 : 0) - static_cast<int>(settings_.bomb * bombs_out) -
         static_cast<int>(settings_.wood * future.wood.Count()) +
         static_cast<int>(settings_.chase * attraction_.At(self.cell));
}

}  // namespace powderkeg

#include "actors/pessimist/pessimist.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace powderkeg {
namespace {

constexpr int kIllegal = std::numeric_limits<int>::min();
constexpr int kDeath = 100'000;    // the own one, in the tree
constexpr int kDoom = 50'000;      // to have no way out
constexpr int kMateDoom = 10'000;  // that the mate has none
constexpr int kBounce = 200;       // a move that led nowhere before
// An enemy with so many pairs is as good as caught.
constexpr int kEnemyRoom = 4;
// Steps for which we stand in the enemies' way wherever we can go.
constexpr int kOwnSpread = 1;
constexpr CellsByStep kFree{};

// Tactics: what one is worth, of so many at most.
constexpr int kEnough = 6;
constexpr int kAmmo = 60;
constexpr int kBlast = 30;
constexpr int kKick = 60;
constexpr int kWood = 12;  // burnt
// What it is worth to be at an item, beside wood, at an enemy.
constexpr int kItemWorth = 30;
constexpr int kWoodWorth = 16;
constexpr int kEnemyWorth = 20;

// 64 log2(number), linear between powers of two.
int Logarithm(unsigned number) {
  const int power = std::bit_width(number) - 1;
  return 64 * power + static_cast<int>(((number - (1U << power)) << 6) >> power);
}

}  // namespace

Action Pessimist::Choose(const GameSettings& game, const State& state, AgentId self,
                         BitBoard visible, Rng& rng, std::optional<Action> bounced) {
  std::array<int, kActionCount> values = Values(game, state, self, visible);
  if (bounced && rng.Below(2) == 0) {
    int& value = values[static_cast<std::size_t>(*bounced)];
    value = std::max(value, kIllegal + kBounce) - kBounce;
  }
  const int best = *std::ranges::max_element(values);
  auto skipped = rng.Below(static_cast<std::uint32_t>(std::ranges::count(values, best)));
  for (std::size_t action = 0;; ++action) {
    if (values[action] == best && skipped-- == 0) return static_cast<Action>(action);
  }
}

std::array<int, kActionCount> Pessimist::Values(const GameSettings& game, const State& state,
                                                AgentId self, BitBoard visible) {
  game_ = game;
  self_ = self;
  futures_.Clear();
  LookAround(state, visible);
  AttractBy(state);
  const Replies replies = RepliesTo(state, self, enemies_ & in_view_, settings_.near);
  depth_ = replies.count > 1 ? settings_.depth : settings_.depth + 1;
  const ActionSet legal = LegalActions(state, self);
  std::array<int, kActionCount> values;
  values.fill(kIllegal);
  for (std::size_t action = 0; action < values.size(); ++action) {
    if (Has(legal, action)) values[action] = ValueOf(state, replies, static_cast<Action>(action));
  }
  return values;
}

void Pessimist::LookAround(const State& state, BitBoard visible) {
  enemies_ = LivingEnemies(game_.mode, state, self_);
  in_view_ = 0;
  living_mate_ = -1;
  for (AgentId id = 0; id < kAgentCount; ++id) {
    const AgentState& agent = state.agents[id];
    if (id == self_ || !agent.alive) continue;
    if (id == TeamMateOf(game_.mode, self_)) living_mate_ = id;
    if (visible.Has(agent.cell)) in_view_ |= static_cast<std::uint8_t>(1 << id);
  }
}

void Pessimist::AttractBy(const State& state) {
  attraction_ = {};
  const BombFuture& future = futures_.For(game_, state);
  const AgentState& self = state.agents[self_];
  const BitBoard doomed = state.wood & ~future.wood;
  const BitBoard walls = state.rigid | (state.wood & ~doomed);
  attraction_.Add(state.VisibleItems(), kItemWorth);
  if (self.ammo > 0) attraction_.Add((state.wood & ~doomed).Neighbours() & ~walls, kWoodWorth);
  for (AgentId id = 0; id < kAgentCount; ++id) {
    if (IsEnemy(id)) {
      attraction_.Add(BitBoard::Of(state.agents[id].cell), kEnemyWorth);
    }
  }
  attraction_.Spread(~(walls | state.bomb_cells) | BitBoard::Of(self.cell));
}

int Pessimist::ValueOf(const State& state, const Replies& replies, Action action) {
  int worst = std::numeric_limits<int>::max();
  int sum = 0;
  for (int i = 0; i < replies.count; ++i) {
    JointAction actions = replies.actions[i];
    actions[self_] = action;
    const int value = ValueAfter(state, actions, depth_ - 1);
    worst = std::min(worst, value);
    sum += value;
  }
  const double mean = static_cast<double>(sum) / replies.count;
  return static_cast<int>(settings_.fear * worst + (1 - settings_.fear) * mean);
}

int Pessimist::ValueAfter(State state, const JointAction& actions, int depth) {
  Step(game_, actions, state);
  Collapse(game_, state);
  if (!state.agents[self_].alive) return -kDeath;
  return depth == 0 ? LeafValue(state) : Best(state, depth);
}

// Everybody else waits.
int Pessimist::Best(const State& state, int depth) {
  const ActionSet legal = LegalActions(state, self_);
  int best = std::numeric_limits<int>::min();
  for (std::size_t action = 0; action < kActionCount; ++action) {
    if (!Has(legal, action)) continue;
    JointAction actions{};
    actions[self_] = static_cast<Action>(action);
    best = std::max(best, ValueAfter(state, actions, depth - 1));
  }
  return best;
}

int Pessimist::LeafValue(const State& state) {
  const BombFuture& future = futures_.For(game_, state);
  return Survivabilities(state, future) + Tactics(state, future);
}

int Pessimist::Survivabilities(const State& state, const BombFuture& future) const {
  const CellsByStep theirs =
      CellsOf(future, state, enemies_ & in_view_, settings_.spread, in_view_);
  const Cell cell = state.agents[self_].cell;
  int value = OwnValue(CountPairs(SurvivableCells(future, cell, theirs)));
  if (value <= -kDoom) value += CountPairs(ReachableCells(future, cell, theirs));
  const CellsByStep ours = ReachableCells(future, cell, kOwnSpread);
  for (AgentId id = 0; id < kAgentCount; ++id) {
    const bool enemy = IsEnemy(id);
    if (!enemy && id != living_mate_) continue;
    const AgentState& agent = state.agents[id];
    const CellsByStep& taken = enemy ? ours : kFree;
    const int pairs = agent.alive ? CountPairs(SurvivableCells(future, agent.cell, taken)) : 0;
    value += enemy ? EnemyValue(pairs, agent.alive) : MateValue(pairs);
    if (enemy && agent.alive && pairs == 0) {  // the sooner the better
      value -= CountPairs(ReachableCells(future, agent.cell, taken));
    }
  }
  return value;
}

int Pessimist::OwnValue(int pairs) const { return pairs == 0 ? -kDoom : -settings_.own / pairs; }

int Pessimist::MateValue(int pairs) const {
  return pairs == 0 ? -kMateDoom : -settings_.mate / pairs;
}

int Pessimist::EnemyValue(int pairs, bool alive) const {
  const auto room = static_cast<unsigned>(pairs + kEnemyRoom);
  const int doom = pairs > 0 ? 0 : (alive ? settings_.kill : 2 * settings_.kill);
  return doom + settings_.enemy / (pairs + kEnemyRoom) - settings_.siege * Logarithm(room) / 64;
}

int Pessimist::Tactics(const State& state, const BombFuture& future) const {
  const AgentState& self = state.agents[self_];
  int bombs_out = 0;
  int bomb_life = 0;  // costs a little, so that bombs are laid for a reason and soon
  for (const Bomb& bomb : state.Bombs()) {
    if (bomb.owner() != self_) continue;
    ++bombs_out;
    bomb_life += bomb.life;
  }
  return kAmmo * std::min(self.ammo + bombs_out, kEnough) +
         kBlast * std::min<int>(self.blast_strength, kEnough) + (self.can_kick ? kKick : 0) -
         bomb_life / 2 - kWood * future.wood.Count() + attraction_.At(self.cell);
}

}  // namespace powderkeg

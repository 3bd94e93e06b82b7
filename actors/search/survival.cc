#include "actors/search/survival.h"

#include <algorithm>
#include <array>
#include <limits>

namespace powderkeg {
namespace {

constexpr int kNear = 6;
constexpr int kEnemySpread = 3;
constexpr int kOwnSpread = 1;
constexpr float kHalfDistress = 8;  // pairs
// More than any number of pairs: what is left after bombs that may still be laid.
constexpr int kAfterBombs = (kForesight + 1) * kCellCount;
constexpr int kDead = -1;

float Distress(const BombFuture& future, const AgentState& agent, const CellsByStep& taken) {
  if (!agent.alive) return 1;
  const int pairs = CountPairs(SurvivableCells(future, agent.cell, taken));
  return kHalfDistress / (kHalfDistress + static_cast<float>(pairs));
}

AgentSet EverybodyBut(AgentId self) { return static_cast<AgentSet>(0b1111 & ~(1U << self)); }

}  // namespace

Survival::Survival(const SearchSettings& settings, const GameSettings& game)
    : caution_(settings.caution),
      room_(static_cast<float>(settings.room)),
      hunt_(static_cast<float>(settings.hunt)),
      game_(game) {}

// --- Caution -----------------------------------------------------------------------------------

ActionSet Survival::CautiousActions(const State& state, AgentId self, ActionSet legal) {
  if (caution_ == 0) return legal;
  futures_.Clear();
  const AgentSet enemies = LivingEnemies(game_.mode, state, self);
  const Replies replies = RepliesTo(state, self, enemies, kNear);
  std::array<int, kActionCount> worst;
  worst.fill(kDead);
  for (std::size_t action = 0; action < kActionCount; ++action) {
    if (!Has(legal, action)) continue;
    worst[action] = std::numeric_limits<int>::max();
    for (int i = 0; i < replies.count && worst[action] > kDead; ++i) {
      JointAction actions = replies.actions[i];
      actions[self] = static_cast<Action>(action);
      worst[action] = std::min(worst[action], PairsLeft(state, actions, self));
    }
  }
  const int enough = std::min(kAfterBombs + caution_, std::ranges::max(worst));
  unsigned cautious = 0;
  for (std::size_t action = 0; action < kActionCount; ++action) {
    if (worst[action] >= enough) cautious |= 1U << action;
  }
  return static_cast<ActionSet>(cautious & legal);
}

// After a step: S', or S where that is 0.
int Survival::PairsLeft(State state, const JointAction& actions, AgentId self) {
  Step(game_, actions, state);
  Collapse(game_, state);
  if (!state.agents[self].alive) return kDead;
  const AgentSet enemies = LivingEnemies(game_.mode, state, self);
  const auto pairs = [&] {
    const BombFuture& future = futures_.For(game_, state);
    const CellsByStep taken = CellsOf(future, state, enemies, kEnemySpread, EverybodyBut(self));
    return CountPairs(SurvivableCells(future, state.agents[self].cell, taken));
  };
  const int left = pairs();
  if (left == 0) return 0;
  const int left_then = LayBombs(self, enemies, kNear, state) ? pairs() : left;
  return left_then > 0 ? kAfterBombs + left_then : left;
}

// --- Room --------------------------------------------------------------------------------------

float Survival::Weigh(float value, const State& state, AgentId self) const {
  if (room_ == 0 && hunt_ == 0) return value;
  const BombFuture future = ForeseeBombs(game_, state);
  const CellsByStep ours = ReachableCells(future, state.agents[self].cell, kOwnSpread);
  float own = OwnDistress(future, state, self);
  float enemies = 0;
  int enemy_count = 0;
  for (AgentId id = 0; id < SeatCount(game_.mode); ++id) {
    if (AreEnemies(game_.mode, self, id)) {
      enemies += Distress(future, state.agents[id], ours);
      ++enemy_count;
    } else if (id != self) {
      own += Distress(future, state.agents[id], {}) / 2;
    }
  }
  value += hunt_ * enemies / static_cast<float>(enemy_count) - room_ * own;
  return std::clamp(value, -1.0F, 1.0F);
}

float Survival::OwnDistress(const BombFuture& future, const State& state, AgentId self) const {
  const AgentSet enemies = LivingEnemies(game_.mode, state, self);
  const CellsByStep taken = CellsOf(future, state, enemies, kEnemySpread, 0);
  const float now = Distress(future, state.agents[self], taken);
  State bombed = state;
  if (!LayBombs(self, enemies, kNear, bombed)) return now;
  const BombFuture worse = ForeseeBombs(game_, bombed);
  return (now + Distress(worse, state.agents[self], taken)) / 2;
}

}  // namespace powderkeg

#pragma once

// A tree of a few steps whose leaves are worth the room to live that everybody is left with in the
// worst case: after the winner of the team tournament of 2018 (Osogami and Takahashi, "Real-time
// tree search with pessimistic scenarios", arXiv 1902.10870). The details are our own.
//
// Tree: the own legal actions for `depth` steps. In the first step an enemy nearby answers each of
// them with each of its own, one enemy at a time; else everybody waits. An action is worth
// fear * the worst + (1 - fear) * the mean over these replies of the best that can follow.
//
// Leaf: what lies on the board goes off (ForeseeBombs), enemies in view are everywhere at once that
// they can reach in `spread` steps, and the mate stays. With S the survivability of an agent
// (CountPairs of its SurvivableCells), of enemies among the cells that we can reach in one step,
//
//   value = - own / S(self) - mate / S(mate)
//           + sum over enemies of enemy / (S + 4) - siege * log2(S + 4)
//           + kill for every enemy without a way out, twice for a dead one
//           + tactics
//
// S = 0 of one's own is the worst, S = 0 of the mate the next; each counts the more the sooner.
// Tactics: what was picked up, wood that will have burnt, and where it is good to be (Attraction).

#include <array>
#include <cstdint>
#include <optional>

#include "actors/pessimist/attraction.h"
#include "common/base/rng.h"
#include "common/config/pessimist_settings.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/replies.h"
#include "common/pommerman/state.h"
#include "common/pommerman/step.h"
#include "common/pommerman/survivability.h"

namespace powderkeg {

// One thread; reused over games, nothing of which it remembers. Allocates nothing.
class Pessimist {
 public:
  explicit Pessimist(const PessimistSettings& settings) : settings_(settings) {}

  // The action of `self`, which must be alive, on what it believes of the position. Enemies outside
  // `visible` are where they are believed to be, but get in nobody's way. A move that led nowhere
  // in the step before (`bounced`) is given up half of the time: whoever wants the same cell would
  // want it forever. Equal arguments give equal actions.
  [[nodiscard]] Action Choose(const GameSettings& game, const State& state, AgentId self,
                              BitBoard visible, Rng& rng, std::optional<Action> bounced = {});

  // What it thinks of every action, the same under all symmetries of the board.
  [[nodiscard]] std::array<int, kActionCount> Values(const GameSettings& game, const State& state,
                                                     AgentId self, BitBoard visible);

 private:
  [[nodiscard]] bool IsEnemy(AgentId id) const { return (enemies_ >> id & 1) != 0; }
  void LookAround(const State& state, BitBoard visible);
  void AttractBy(const State& state);
  [[nodiscard]] int ValueOf(const State& state, const Replies& replies, Action action);
  [[nodiscard]] int ValueAfter(State state, const JointAction& actions, int depth);
  [[nodiscard]] int Best(const State& state, int depth);
  [[nodiscard]] int LeafValue(const State& state);
  [[nodiscard]] int Survivabilities(const State& state, const BombFuture& future) const;
  [[nodiscard]] int OwnValue(int pairs) const;
  [[nodiscard]] int MateValue(int pairs) const;
  [[nodiscard]] int EnemyValue(int pairs, bool alive) const;
  [[nodiscard]] int Tactics(const State& state, const BombFuture& future) const;

  PessimistSettings settings_;
  GameSettings game_;
  AgentId self_ = 0;
  AgentId living_mate_ = -1;  // none: -1
  AgentSet enemies_ = 0;      // that live
  AgentSet in_view_ = 0;      // living others
  int depth_ = 0;
  Attraction attraction_;
  FutureMemory futures_;
};

}  // namespace powderkeg

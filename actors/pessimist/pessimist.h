#pragma once

// A tree of a few steps whose leaves are worth the room to live that everybody is left with in the
// worst case: after the winner of the team tournament of 2018 (Osogami and Takahashi, "Real-time
// tree search with pessimistic scenarios", arXiv 1902.10870).

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "actors/pessimist/attraction.h"
#include "common/base/rng.h"
#include "common/config/pessimist_settings.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"
#include "common/pommerman/step.h"
#include "common/pommerman/survivability.h"

namespace powderkeg {

// The foresights of a decision, by what lies on the board.
class FutureMemory {
 public:
  void Clear() { count_ = 0; }
  [[nodiscard]] const BombFuture& For(const GameSettings& settings, const State& state);

 private:
  static constexpr std::size_t kSize = 64;
  struct Entry {
    std::array<Bomb, kMaxBombs> bombs;
    int bomb_count;
    int step;
    BitBoard wood;
    BitBoard items;
    BombFuture future;
  };
  [[nodiscard]] static bool Fits(const Entry& entry, const State& state);

  std::array<Entry, kSize> entries_;
  std::size_t count_ = 0;
};

class Pessimist {
 public:
  explicit Pessimist(const PessimistSettings& settings) : settings_(settings) {}

  // The action of `self`, which must be alive, on what it believes of the position. Enemies outside
  // `visible` are where they are believed to be, but get in nobody's way. Equal positions and
  // generators give equal actions.
  [[nodiscard]] Action Choose(const GameSettings& game, const State& state, AgentId self,
                              BitBoard visible, Rng& rng);

  // What it thinks of every action, the same under all symmetries of the board.
  [[nodiscard]] std::array<int, kActionCount> Values(const GameSettings& game, const State& state,
                                                     AgentId self, BitBoard visible);

 private:
  // What everybody else does in the first step.
  struct Replies {
    std::array<JointAction, 2 * kActionCount> actions;
    int count = 0;
  };

  void LookAround(const State& state, BitBoard visible);
  void AttractBy(const State& state);
  [[nodiscard]] Replies RepliesTo(const State& state, BitBoard visible) const;
  [[nodiscard]] int ValueOf(const State& state, const Replies& replies, Action action);
  [[nodiscard]] int Best(const State& state, int depth);
  [[nodiscard]] int LeafValue(const State& state);
  [[nodiscard]] int Survivabilities(const State& state, const BombFuture& future) const;
  [[nodiscard]] CellsByStep CellsOfOthers(const State& state, const BombFuture& future) const;
  [[nodiscard]] int OwnValue(int pairs) const;
  [[nodiscard]] int MateValue(int pairs) const;
  [[nodiscard]] int EnemyValue(int pairs, bool alive) const;
  [[nodiscard]] int Tactics(const State& state, const BombFuture& future) const;

  PessimistSettings settings_;
  GameSettings game_;
  AgentId self_ = 0;
  AgentId living_mate_ = -1;     // none: -1
  std::uint8_t enemies_ = 0;     // bit i: agent i lives and is an enemy
  std::uint8_t in_the_way_ = 0;  // bit i: agent i is in view, too
  int depth_ = 0;
  Attraction attraction_;
  FutureMemory futures_;
};

}  // namespace powderkeg

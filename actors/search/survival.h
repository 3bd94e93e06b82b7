#pragma once

// What a search knows of staying alive beside its evaluator. Bombs decide games ten steps later
// than a tree sees, by the room to live that they leave (survivability.h), and enemies need not do
// what their models say.

#include "common/config/search_settings.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/replies.h"
#include "common/pommerman/state.h"
#include "common/pommerman/step.h"
#include "common/pommerman/survivability.h"

namespace powderkeg {

// With S the survivability of an agent (CountPairs of its SurvivableCells) while enemies are
// everywhere at once that they can reach in three steps, and S' the same after every enemy within
// six steps laid a bomb at once. One thread.
class Survival {
 public:
  Survival(const SearchSettings& settings, const GameSettings& game);

  // Of these actions of `self` those that leave settings.caution in the worst case, or as much
  // as the best of them; never empty. The worst case is over the replies of the enemies within six
  // steps. An action leaves S' if that is not 0, else it leaves S, which is less than any S'.
  [[nodiscard]] ActionSet CautiousActions(const State& state, AgentId self, ActionSet legal);

  // An evaluation of a position in which `self` lives, own view, within [-1, 1]:
  //
  //   value - room * ((d(S) + d(S')) / 2 + d(mate) / 2) + hunt * mean of d over all enemies
  //
  // d, an agent's distress, is 8 / (8 + S): 1 where there is no way out, and of the dead. Enemies
  // have us in their way wherever we can be in one step.
  [[nodiscard]] float Weigh(float value, const State& state, AgentId self) const;

 private:
  [[nodiscard]] int PairsLeft(State state, const JointAction& actions, AgentId self);
  [[nodiscard]] float OwnDistress(const BombFuture& future, const State& state, AgentId self) const;

  int caution_;
  float room_;
  float hunt_;
  GameSettings game_;
  FutureMemory futures_;
};

}  // namespace powderkeg

#pragma once

// Positions whose best moves are known, or found by looking at everything.

#include <algorithm>
#include <string_view>
#include <vector>

#include "common/config/search_settings.h"
#include "common/pommerman/step.h"

namespace powderkeg {

// By the evaluator alone, without noise, against idle agents.
inline SearchSettings Quiet(int simulations) {
  SearchSettings settings = WithoutAids({});
  settings.simulations = simulations;
  settings.noise_weight = 0;
  settings.opponents.fill(OpponentModel::kIdle);
  return settings;
}

// --- Known answers, found by looking at everything that agent 0 can do while the others idle -----

// The best outcome for agent 0 within `depth` steps: +1 win, 0 undecided or tie, -1 death.
inline int BestOutcome(const GameSettings& game, const State& state, int depth);

inline int OutcomeAfter(const GameSettings& game, State state, int action, int depth) {
  const Outcome outcome = Advance(game, {static_cast<Action>(action)}, state);
  if (outcome.done) return outcome.rewards[0] > 0 ? 1 : outcome.result == Result::kTie ? 0 : -1;
  if (!state.agents[0].alive) return -1;
  return depth == 1 ? 0 : BestOutcome(game, state, depth - 1);
}

inline int BestOutcome(const GameSettings& game, const State& state, int depth) {
  const ActionSet legal = LegalActions(state, 0);
  int best = -1;
  for (int action = 0; action < kActionCount && best < 1; ++action) {
    if ((legal >> action & 1) == 0) continue;
    best = std::max(best, OutcomeAfter(game, state, action, depth));
  }
  return best;
}

inline std::vector<Action> BestActions(const GameSettings& game, const State& state, int depth) {
  const ActionSet legal = LegalActions(state, 0);
  const int best = BestOutcome(game, state, depth);
  std::vector<Action> actions;
  for (int action = 0; action < kActionCount; ++action) {
    if ((legal >> action & 1) == 0) continue;
    if (OutcomeAfter(game, state, action, depth) == best) {
      actions.push_back(static_cast<Action>(action));
    }
  }
  return actions;
}

// The only way out of the blast leads right, then down.
inline constexpr std::string_view kEscape = R"(
    o.0..######
    ###.#######
    ###########
    ###########
    ###########
    ###########
    ###########
    ###########
    ###########
    ###########
    #########.1
    bomb (0,0) owner 1 life 2 strength 6
)";

// Agent 1 sits in a dead end; agent 0 can lock it in with a bomb and walk away.
inline constexpr std::string_view kKill = R"(
    10.....####
    ###########
    ###########
    ###########
    ###########
    ###########
    ###########
    ###########
    ###########
    ###########
    ###########
)";

// The enemy burns unless it moves.
inline constexpr std::string_view kBurning = R"(
    0..........
    ...........
    #########..
    ........#..
    .......o1..
    ........#..
    ########...
    ...........
    ...........
    ...........
    ...........
    bomb (4,7) owner 0 life 1 strength 2
)";

inline GameSettings EndsAfter(int steps) {
  GameSettings game;
  game.max_steps = steps;
  return game;
}

}  // namespace powderkeg

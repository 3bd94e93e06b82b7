#pragma once

// Positions and weights for the tests of the model layer.

#include <vector>

#include "common/base/rng.h"
#include "common/model/weights_snapshot.h"
#include "common/pommerman/state.h"

namespace powderkeg {

// Positions of games that random legal actions play from official starts.
[[nodiscard]] std::vector<State> PlayedStates(int count, std::uint64_t seed);

// A position with everything in it, reachable or not: many bombs, some of them rolling, flames of
// every life, items and agents with random statistics, dead ones among them.
[[nodiscard]] State BusyState(Rng rng);

// InitialWeights with random batch norm, so that nothing is trivially 0 or 1, and last layers large
// enough for decided policies.
[[nodiscard]] Snapshot RandomWeights(const NetworkDescription& description, std::uint64_t seed);

// Each state as seen by one of its agents, dead ones and fog among them. The states must outlive
// the result.
[[nodiscard]] std::vector<Position> PositionsOf(const std::vector<State>& states);

// The evaluator's answers under default settings.
[[nodiscard]] std::vector<Evaluation> EvaluateAll(Evaluator& evaluator,
                                                  const std::vector<Position>& positions);

// The largest differences in policy probability and value; both have the same size.
[[nodiscard]] CanaryDifference Compare(const std::vector<Evaluation>& a,
                                       const std::vector<Evaluation>& b);

}  // namespace powderkeg

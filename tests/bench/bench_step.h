#pragma once

// Speed of the rules.

#include <vector>

#include "tests/bench/figure.h"

namespace powderkeg {

// Steps, observations, legal actions and start positions per second of CPU time of one thread, on
// replayed games of four SimpleUnbiased agents. About three seconds.
[[nodiscard]] std::vector<BenchFigure> BenchStep();

}  // namespace powderkeg

#pragma once

// Speed of planes and network evaluations.

#include <vector>

#include "tests/bench/figure.h"

namespace powderkeg {

// Evaluations per second of thread CPU time (planes included) for every network, precision and
// batch size of the oneDNN evaluator, and planes per second. About two seconds.
[[nodiscard]] std::vector<BenchFigure> BenchModel();

}  // namespace powderkeg

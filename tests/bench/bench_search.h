#pragma once

// Figures of the tree search.

#include <vector>

#include "tests/bench/figure.h"

namespace powderkeg {

// Simulations per second of one search alone, with the uniform evaluator and three SimpleUnbiased
// models, through the first moves of several games; the parts of a simulation in nanoseconds; the
// size of a node; the signature that pins the search's behaviour. CPU time of one thread.
[[nodiscard]] std::vector<BenchFigure> BenchSearch();

}  // namespace powderkeg

#pragma once

// Figures of the tree search.

#include <vector>

#include "tests/bench/figure.h"

namespace powderkeg {

// Simulations per second of one search alone, in a one-player and in a two-player tree, with the
// uniform evaluator and three SimpleUnbiased models, in the first positions of several games, while
// all four live; the parts of a simulation in nanoseconds; the size of a node; the signature that
// pins the search's behaviour. CPU time of one thread.
[[nodiscard]] std::vector<BenchFigure> BenchSearch();

}  // namespace powderkeg

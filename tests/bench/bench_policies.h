#pragma once

// Figures of the rule-based agents.

#include <vector>

#include "tests/bench/figure.h"

namespace powderkeg {

// Whole games of four equal agents in steps per second, single decisions in decisions per second,
// and the verification of records in decisions per second; by CPU time of one thread.
[[nodiscard]] std::vector<BenchFigure> BenchPolicies();

}  // namespace powderkeg

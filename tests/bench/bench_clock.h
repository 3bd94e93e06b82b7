#pragma once

// What a search under a clock gets done, served as agent_server serves it.

#include <vector>

#include "tests/bench/figure.h"

namespace powderkeg {

// Simulations and network evaluations of a move with untrained weights of the published network, in
// 100 and 80 ms, with one thread and with two; the share of questions answered from memory; the
// slowest move. Positions of rule-based games, none following another: no tree is reused. Wall
// time: wants as many free cores as threads. About seven seconds.
[[nodiscard]] std::vector<BenchFigure> BenchClock();

}  // namespace powderkeg

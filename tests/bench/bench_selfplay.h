#pragma once

// What an actor gets done on one core.

#include <vector>

#include "tests/bench/figure.h"

namespace powderkeg {

// One game loop of an actor, with the games, evaluator and memory for answers that an actor has by
// default, searching with 250 simulations against three SimpleUnbiased; first with the uniform
// evaluator, then with untrained weights of each network: simulations and network evaluations per
// second of the thread's CPU time, the share of questions answered from memory, positions in a
// batch of the network, the share of the time spent in the network, and what the rest costs a
// simulation. Games are in all their stages. About fifteen seconds.
[[nodiscard]] std::vector<BenchFigure> BenchSelfPlay();

}  // namespace powderkeg

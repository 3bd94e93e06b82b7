#pragma once

#include <vector>

#include "tests/bench/figure.h"

namespace powderkeg {

// bytes_per_decision: of a record as it is sent.
// ingest: decisions/s that the learner takes from fake actors over ipc: received, decoded,
// verified, handed to a store (in memory), acknowledged. ingest_per_core: the same per second
// of processor time of the whole process, fake actors included.
// Takes a few seconds.
[[nodiscard]] std::vector<BenchFigure> BenchWire();

}  // namespace powderkeg

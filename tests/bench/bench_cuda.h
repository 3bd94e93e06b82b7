#pragma once

// Speed of network evaluations on a CUDA device.

#include <vector>

#include "tests/bench/figure.h"

namespace powderkeg {

// Evaluations per second of wall time through the Evaluator interface (bytes, copies and answers
// included), one thread, fp16, for every network and several batch sizes. Nothing without a device.
[[nodiscard]] std::vector<BenchFigure> BenchCuda();

}  // namespace powderkeg

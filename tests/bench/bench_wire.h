#pragma once

#include <vector>

#include "tests/bench/figure.h"

namespace powderkeg {

// bytes_per_decision: of a record as it is sent.
// ingest_hdf5: decisions that the learner takes from two actor processes over ipc (received,
// decoded, verified, stored durably as HDF5 in the folder for temporary files, acknowledged) per
// second of its processor time, all its threads together.
// ingest_per_core: the same with a store in memory.
// Takes a few seconds.
[[nodiscard]] std::vector<BenchFigure> BenchWire();

}  // namespace powderkeg

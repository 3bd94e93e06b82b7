#pragma once

// Evaluation on a CUDA device. Built only with a LibTorch that has CUDA.

#include <memory>

#include "common/model/evaluator.h"
#include "common/model/weights_snapshot.h"
#include "common/torch/torch_evaluator.h"

namespace powderkeg {

// Batches are padded to one of a few sizes; for each of them everything from the copy of the bytes
// to the copy of the answers is captured once as a CUDA graph, on a stream of this evaluator's own,
// and replayed from then on. The first batch of a size is slow.
[[nodiscard]] std::unique_ptr<Evaluator> MakeCudaEvaluator(const WeightsSnapshot& snapshot,
                                                           const TorchEvaluatorSettings& settings);

}  // namespace powderkeg

#pragma once

// Evaluation with LibTorch, on CPUs or CUDA. No Torch type in this header.

#include <cstdint>
#include <memory>

#include "common/model/evaluator.h"
#include "common/model/precision.h"
#include "common/model/weights_snapshot.h"

namespace powderkeg {

enum class TorchDevice : std::uint8_t { kCpu, kCuda };

struct TorchEvaluatorSettings {
  TorchDevice device = TorchDevice::kCpu;
  Precision precision = Precision::kFp32;  // fp16 requires CUDA
  int cuda_index = 0;
};

// Whether LibTorch was built with CUDA and finds a device.
[[nodiscard]] bool IsCudaAvailable();

// An evaluator "torch cpu fp32" or alike for the weights of the snapshot, in evaluation mode. Uses
// one thread of the CPU; several evaluators in several threads run independently (a CUDA stream
// each). Throws Error on invalid weights, an absent device or a precision that the device lacks.
[[nodiscard]] std::unique_ptr<Evaluator> MakeTorchEvaluator(const Snapshot& snapshot,
                                                            const TorchEvaluatorSettings& settings);

}  // namespace powderkeg

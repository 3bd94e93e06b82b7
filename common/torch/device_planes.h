#pragma once

// Input planes from bytes, on any device. Includes Torch: for common/torch alone.

#include "common/torch/torch_headers.h"

namespace powderkeg {

// counts: int8 [positions, 24, 11, 11] of EncodePlaneCounts; scales: [24] of PlaneScales on the
// same device. Returns the planes of EncodePlanes, [positions, 23, 11, 11], of the type of
// `scales`.
[[nodiscard]] torch::Tensor ExpandPlanes(const torch::Tensor& counts, const torch::Tensor& scales);

}  // namespace powderkeg

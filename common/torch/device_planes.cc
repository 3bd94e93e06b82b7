#include "common/torch/device_planes.h"

#include "common/model/planes.h"

namespace powderkeg {

torch::Tensor ExpandPlanes(const torch::Tensor& counts, const torch::Tensor& scales) {
  constexpr int kStepPlane = kPlaneCount - 1;
  const torch::Tensor planes =
      counts.to(scales.scalar_type()) * scales.view({1, kPlaneCount + 1, 1, 1});
  const torch::Tensor step =
      (planes.narrow(1, kStepPlane, 1) + planes.narrow(1, kStepPlane + 1, 1)).clamp_max(1);
  return torch::cat({planes.narrow(1, 0, kStepPlane), step}, 1);
}

}  // namespace powderkeg

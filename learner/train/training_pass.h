#pragma once

// A network forwards and backwards in training mode. Includes Torch: for learner/train alone.

#include <memory>
#include <vector>

#include "common/model/precision.h"
#include "common/torch/torch_headers.h"
#include "common/torch/torch_network.h"
#include "learner/train/fused_tower.h"

namespace powderkeg {

// The tower by FusedTower where that is possible, else all by LibTorch's operations. Not
// thread-safe.
class TrainingPass {
 public:
  // `network` is on the device; its parameters and their gradients stay where they are from now on.
  // Only fp32 and bf16.
  TrainingPass(Network network, torch::Device device, Precision precision, int threads);

  // planes: [positions, 23, 11, 11], on the CPU, unchanged until Backward.
  [[nodiscard]] NetworkOutput Forward(std::vector<float>& planes, std::int64_t positions);
  // Adds to the gradients of all parameters. `loss` follows from the last Forward.
  void Backward(const torch::Tensor& loss);

  [[nodiscard]] bool fused() const { return tower_ != nullptr; }

 private:
  [[nodiscard]] NetworkOutput ForwardFused(const torch::Tensor& planes);

  Network network_;
  torch::Device device_;
  Precision precision_;
  std::unique_ptr<FusedTower> tower_;                // null: LibTorch's operations
  std::vector<ConvolutionParameters> convolutions_;  // for it: where the parameters lie
  HeadInputs head_inputs_;                           // of the last Forward by it
};

}  // namespace powderkeg

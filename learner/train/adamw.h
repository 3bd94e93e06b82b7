#pragma once

// AdamW (Loshchilov and Hutter 2019) with betas 0.9 and 0.999. Includes Torch: for learner/train
// alone.

#include <cstdint>
#include <string>
#include <vector>

#include "common/torch/torch_headers.h"
#include "learner/train/trainer_state.h"

namespace powderkeg {

// Not thread-safe.
class AdamW {
 public:
  // Moments of 0, after so many steps. The module's parameters are changed in place.
  AdamW(const torch::nn::Module& module, double weight_decay, std::uint64_t steps);

  // Moments by the names of their parameters, as Arrays gives them. Throws Error if one is missing
  // or has another shape.
  void Restore(const std::vector<NamedArray>& arrays);
  // Empty before the first step. Waits for the device.
  [[nodiscard]] std::vector<NamedArray> Arrays() const;

  void ZeroGradients();
  // From the gradients, of which none may be undefined.
  void Step(double learning_rate);

  [[nodiscard]] std::uint64_t steps() const { return steps_; }

 private:
  struct Parameter {
    std::string name;
    torch::Tensor values;
    torch::Tensor first_moment;
    torch::Tensor second_moment;
  };

  std::vector<Parameter> parameters_;
  double weight_decay_;
  std::uint64_t steps_;
};

}  // namespace powderkeg

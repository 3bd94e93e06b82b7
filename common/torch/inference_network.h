#pragma once

// The forward pass of a network for play: batch norm folded, tensors of one type on one device.
// Includes Torch: for common/torch alone.

#include <span>
#include <vector>

#include "common/model/evaluator.h"
#include "common/model/folded_network.h"
#include "common/model/precision.h"
#include "common/torch/torch_headers.h"

namespace powderkeg {

[[nodiscard]] torch::ScalarType ScalarTypeOf(Precision precision);

// Policy probabilities, the value, then the probabilities of the three others; 0 of those that are
// not foretold.
inline constexpr int kAnswerSize = kActionCount + 1 + (kAgentCount - 1) * kActionCount;

// Reads the first rows of what Forward returned, once it is on the CPU.
void TakeAnswers(const torch::Tensor& answers, std::span<Evaluation> evaluations);

class InferenceNetwork {
 public:
  // `options`: type and device of weights and activations.
  InferenceNetwork(const FoldedNetwork& network, torch::TensorOptions options);

  // planes: [positions, 23, 11, 11] of any type on any device. Returns [positions, kAnswerSize] as
  // fp32 on the network's device. The same operations on every call, so that it can be captured as
  // a CUDA graph.
  [[nodiscard]] torch::Tensor Forward(const torch::Tensor& planes) const;

 private:
  struct Convolution {
    torch::Tensor weights;
    torch::Tensor bias;
    int stride = 1;
    int padding = 0;
    int groups = 1;
  };
  struct Linear {
    torch::Tensor weights;
    torch::Tensor bias;  // undefined: 0
  };
  struct BlockLayers {
    std::vector<Convolution> convolutions;
    bool skip;
    bool final_activation;
  };

  [[nodiscard]] torch::Tensor Tensor(const std::vector<float>& values,
                                     torch::IntArrayRef shape) const;
  [[nodiscard]] Convolution Load(const FoldedConvolution& layer) const;
  [[nodiscard]] Linear Load(const LinearLayer& layer) const;

  [[nodiscard]] torch::Tensor ToInput(const torch::Tensor& planes) const;
  [[nodiscard]] torch::Tensor Activate(torch::Tensor x) const;
  [[nodiscard]] static torch::Tensor Run(const Convolution& layer, const torch::Tensor& x);
  [[nodiscard]] static torch::Tensor Run(const Linear& layer, const torch::Tensor& x);
  [[nodiscard]] torch::Tensor Run(const BlockLayers& block, const torch::Tensor& input) const;
  // As NetworkImpl::OwnFeatures.
  [[nodiscard]] torch::Tensor OwnFeatures(const torch::Tensor& tower,
                                          const torch::Tensor& input) const;
  // [positions, 18]
  [[nodiscard]] torch::Tensor Others(const torch::Tensor& tower, const torch::Tensor& input) const;

  torch::TensorOptions options_;
  double leaky_slope_;
  Convolution stem_;
  std::vector<BlockLayers> blocks_;
  Convolution value_convolution_;
  Linear value_hidden_;
  Linear value_output_;
  Convolution policy_convolution_;
  Linear policy_output_;
  bool has_own_head_ = false;
  Linear own_hidden_;
  Linear own_value_;
  Linear own_policy_;
  bool foretells_ = false;
  Linear others_hidden_;
  Linear others_policy_;
};

}  // namespace powderkeg

#pragma once

// The network as a LibTorch module. Includes Torch: for common/torch and learner/train alone.

#include <vector>

#include "common/model/network_description.h"
#include "common/torch/torch_headers.h"

namespace powderkeg {

struct NetworkOutput {
  torch::Tensor policy_logits;  // [positions, 6]
  torch::Tensor value;          // [positions], -1 to +1
  // [positions, 3, 6], of viewer + 1, + 2, + 3; 0 of who is not marked in the planes. Undefined
  // where the network foretells nobody.
  torch::Tensor others_logits;
};

// What the convolutions hand to the linear layers of the heads.
struct HeadInputs {
  torch::Tensor value;   // [positions, value channels * cells], as the others activated
  torch::Tensor policy;  // [positions, policy channels * cells]
  // [positions, 4, channels], what the tower has of the cells of viewer, viewer + 1, + 2, + 3, and
  // [positions, 4], 1 of who is marked in the planes (else 0, as its channels are). Undefined where
  // the network has neither head that asks for them.
  torch::Tensor marked;
  torch::Tensor present;
};

// One block of the tower (see BlockDescription).
class BlockImpl : public torch::nn::Module {
 public:
  BlockImpl(int inputs, const BlockDescription& description, double leaky_slope);
  torch::Tensor forward(const torch::Tensor& input);

 private:
  void AddConvolution(int inputs, int outputs, int kernel, int stride, int groups);

  BlockDescription description_;
  bool skip_;
  double leaky_slope_;
  std::vector<torch::nn::Conv2d> convolutions_;
  std::vector<torch::nn::BatchNorm2d> norms_;
};
TORCH_MODULE(Block);

// The module of a description. Parameters and buffers have the names of ArraysOf (and batch norm's
// num_batches_tracked besides). Weights are LibTorch's random ones until LoadWeights or
// MakeNetwork (snapshot_conversion.h). Convolutions are fastest with `to(channels_last)`.
class NetworkImpl : public torch::nn::Module {
 public:
  // Throws Error on an invalid description.
  explicit NetworkImpl(const NetworkDescription& description);

  // planes: [positions, 23, 11, 11].
  NetworkOutput forward(const torch::Tensor& planes);
  // Its two halves: all convolutions, and the linear layers behind them.
  HeadInputs Convolve(const torch::Tensor& planes);
  NetworkOutput Heads(const HeadInputs& inputs);

  [[nodiscard]] const NetworkDescription& description() const { return description_; }

 private:
  // A convolution with its norm, and the linear layers of a head behind them.
  struct Branch {
    torch::nn::Conv2d convolution{nullptr};
    torch::nn::BatchNorm2d norm{nullptr};
  };
  Branch RegisterBranch(torch::nn::Module& parent, int inputs, int outputs, int kernel, int stride);
  torch::Tensor Run(Branch& branch, const torch::Tensor& input) const;
  void RegisterHeads(int channels);
  void RegisterCellHeads(int channels);
  // [positions, own_hidden] from what the tower says of the own cell.
  torch::Tensor OwnFeatures(const HeadInputs& inputs);
  torch::Tensor OthersLogits(const HeadInputs& inputs);

  NetworkDescription description_;
  Branch stem_;
  std::vector<Block> blocks_;
  Branch value_;
  torch::nn::Linear value_hidden_{nullptr};
  torch::nn::Linear value_output_{nullptr};
  Branch policy_;
  torch::nn::Linear policy_output_{nullptr};
  // The own head; null without one.
  torch::nn::Linear own_hidden_{nullptr};
  torch::nn::Linear own_value_{nullptr};
  torch::nn::Linear own_policy_{nullptr};
  // Likewise.
  torch::nn::Linear others_hidden_{nullptr};
  torch::nn::Linear others_policy_{nullptr};
};
TORCH_MODULE(Network);

}  // namespace powderkeg

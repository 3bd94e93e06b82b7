#include "common/torch/torch_network.h"

#include "common/model/planes.h"
#include "common/pommerman/types.h"

namespace powderkeg {
namespace {

torch::nn::Conv2d MakeConvolution(int inputs, int outputs, int kernel, int stride, int groups) {
  return torch::nn::Conv2d(torch::nn::Conv2dOptions(inputs, outputs, kernel)
                               .stride(stride)
                               .padding(kernel / 2)
                               .groups(groups)
                               .bias(false));
}

torch::nn::BatchNorm2d MakeNorm(int channels) {
  return torch::nn::BatchNorm2d(torch::nn::BatchNorm2dOptions(channels).eps(kBatchNormEpsilon));
}

// In place; batch norm and sums do not need their results for the backward pass.
torch::Tensor Activate(torch::Tensor x, double leaky_slope) {
  return torch::leaky_relu_(x, leaky_slope);
}

const NetworkDescription& Validated(const NetworkDescription& description) {
  Validate(description);
  return description;
}

}  // namespace

BlockImpl::BlockImpl(int inputs, const BlockDescription& description, double leaky_slope)
    : description_(description), skip_(HasSkip(description, inputs)), leaky_slope_(leaky_slope) {
  const auto [kind, expanded, channels, stride] = description;
  if (kind == BlockDescription::Kind::kResidual) {
    AddConvolution(inputs, channels, /*kernel=*/3, stride, /*groups=*/1);
    AddConvolution(channels, channels, /*kernel=*/3, /*stride=*/1, /*groups=*/1);
  } else {
    AddConvolution(inputs, expanded, /*kernel=*/1, /*stride=*/1, /*groups=*/1);
    AddConvolution(expanded, expanded, /*kernel=*/3, stride, /*groups=*/expanded);
    AddConvolution(expanded, channels, /*kernel=*/1, /*stride=*/1, /*groups=*/1);
  }
}

void BlockImpl::AddConvolution(int inputs, int outputs, int kernel, int stride, int groups) {
  const std::string number = std::to_string(convolutions_.size() + 1);
  convolutions_.push_back(
      register_module("conv" + number, MakeConvolution(inputs, outputs, kernel, stride, groups)));
  norms_.push_back(register_module("bn" + number, MakeNorm(outputs)));
}

torch::Tensor BlockImpl::forward(const torch::Tensor& input) {
  torch::Tensor x = input;
  for (std::size_t i = 0; i < convolutions_.size(); ++i) {
    x = norms_[i](convolutions_[i](x));
    if (i + 1 < convolutions_.size()) x = Activate(x, leaky_slope_);
  }
  if (skip_) x = x + input;
  if (description_.kind == BlockDescription::Kind::kResidual) x = Activate(x, leaky_slope_);
  return x;
}

NetworkImpl::NetworkImpl(const NetworkDescription& description)
    : description_(Validated(description)) {
  auto stem = register_module("stem", std::make_shared<torch::nn::Module>());
  stem_ = RegisterBranch(*stem, description.planes, description.stem_channels, /*kernel=*/3,
                         description.stem_stride);
  auto tower = register_module("blocks", std::make_shared<torch::nn::Module>());
  int channels = description.stem_channels;
  for (const BlockDescription& block : description.blocks) {
    blocks_.push_back(tower->register_module(std::to_string(blocks_.size()),
                                             Block(channels, block, description.leaky_slope)));
    channels = block.channels;
  }
  RegisterHeads(channels);
}

void NetworkImpl::RegisterHeads(int channels) {
  const int cells = TowerBoardSize(description_) * TowerBoardSize(description_);
  auto value = register_module("value", std::make_shared<torch::nn::Module>());
  value_ =
      RegisterBranch(*value, channels, description_.value_channels, /*kernel=*/1, /*stride=*/1);
  value_hidden_ = value->register_module(
      "fc1", torch::nn::Linear(description_.value_channels * cells, description_.value_hidden));
  value_output_ = value->register_module("fc2", torch::nn::Linear(description_.value_hidden, 1));
  auto policy = register_module("policy", std::make_shared<torch::nn::Module>());
  policy_ =
      RegisterBranch(*policy, channels, description_.policy_channels, /*kernel=*/1, /*stride=*/1);
  policy_output_ = policy->register_module(
      "fc", torch::nn::Linear(description_.policy_channels * cells, kActionCount));
  RegisterCellHeads(channels);
}

void NetworkImpl::RegisterCellHeads(int channels) {
  if (const int others = description_.others_hidden; others > 0) {
    auto head = register_module("others", std::make_shared<torch::nn::Module>());
    others_hidden_ = head->register_module("fc", torch::nn::Linear(channels, others));
    others_policy_ = head->register_module("policy", torch::nn::Linear(others, kActionCount));
  }
  if (description_.own_hidden == 0) return;
  const int own = description_.own_hidden;
  const auto matrix = [own](int outputs) {
    return torch::nn::Linear(torch::nn::LinearOptions(own, outputs).bias(false));
  };
  auto own_head = register_module("own", std::make_shared<torch::nn::Module>());
  own_hidden_ = own_head->register_module("fc", torch::nn::Linear(channels, own));
  own_value_ = own_head->register_module("value", matrix(description_.value_hidden));
  own_policy_ = own_head->register_module("policy", matrix(kActionCount));
}

NetworkImpl::Branch NetworkImpl::RegisterBranch(torch::nn::Module& parent, int inputs, int outputs,
                                                int kernel, int stride) {
  return {.convolution = parent.register_module(
              "conv", MakeConvolution(inputs, outputs, kernel, stride, /*groups=*/1)),
          .norm = parent.register_module("bn", MakeNorm(outputs))};
}

torch::Tensor NetworkImpl::Run(Branch& branch, const torch::Tensor& input) const {
  return Activate(branch.norm(branch.convolution(input)), description_.leaky_slope);
}

torch::Tensor NetworkImpl::OwnFeatures(const HeadInputs& inputs) {
  const torch::Tensor channels = inputs.marked.select(/*dim=*/1, 0);
  return Activate(own_hidden_(channels), description_.leaky_slope) *
         inputs.present.slice(/*dim=*/1, 0, 1);
}

torch::Tensor NetworkImpl::OthersLogits(const HeadInputs& inputs) {
  const torch::Tensor channels = inputs.marked.slice(/*dim=*/1, 1);
  const torch::Tensor hidden = Activate(others_hidden_(channels), description_.leaky_slope);
  return others_policy_(hidden) * inputs.present.slice(/*dim=*/1, 1).unsqueeze(2);
}

NetworkOutput NetworkImpl::forward(const torch::Tensor& planes) { return Heads(Convolve(planes)); }

HeadInputs NetworkImpl::Convolve(const torch::Tensor& planes) {
  torch::Tensor tower = Run(stem_, planes);
  for (Block& block : blocks_) tower = block(tower);
  HeadInputs inputs{.value = Run(value_, tower).flatten(1),
                    .policy = Run(policy_, tower).flatten(1),
                    .marked = {},
                    .present = {}};
  if (own_hidden_ || others_hidden_) {
    const torch::Tensor marks =
        planes.slice(/*dim=*/1, kOwnCellPlane, kOwnCellPlane + kAgentCount).flatten(2);
    inputs.marked = marks.matmul(tower.flatten(2).transpose(1, 2));
    inputs.present = marks.sum(2);
  }
  return inputs;
}

NetworkOutput NetworkImpl::Heads(const HeadInputs& inputs) {
  torch::Tensor hidden = value_hidden_(inputs.value);
  torch::Tensor logits = policy_output_(inputs.policy);
  if (own_hidden_) {
    const torch::Tensor own = OwnFeatures(inputs);
    hidden = hidden + own_value_(own);
    logits = logits + own_policy_(own);
  }
  const torch::Tensor value = value_output_(Activate(hidden, description_.leaky_slope));
  return {.policy_logits = logits,
          .value = torch::tanh(value).squeeze(1),
          .others_logits = others_hidden_ ? OthersLogits(inputs) : torch::Tensor()};
}

}  // namespace powderkeg

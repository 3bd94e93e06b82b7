#include "common/torch/inference_network.h"

#include <algorithm>

#include "common/model/planes.h"

namespace powderkeg {

torch::ScalarType ScalarTypeOf(Precision precision) {
  switch (precision) {
    case Precision::kBf16: return torch::kBFloat16;
    case Precision::kFp16: return torch::kFloat16;
    case Precision::kInt8:
    case Precision::kFp32: break;
  }
  return torch::kFloat32;
}

void TakeAnswers(const torch::Tensor& answers, std::span<Evaluation> evaluations) {
  const torch::Tensor rows = answers.contiguous();
  const float* answer = rows.data_ptr<float>();
  for (Evaluation& evaluation : evaluations) {
    std::copy_n(answer, kActionCount, evaluation.policy.begin());
    evaluation.value = answer[kActionCount];
    const float* other = answer + kActionCount + 1;
    for (auto& policy : evaluation.others) {
      std::transform(other, other + kActionCount, policy.begin(), InWholes);
      other += kActionCount;
    }
    answer += kAnswerSize;
  }
}

InferenceNetwork::InferenceNetwork(const FoldedNetwork& network, torch::TensorOptions options)
    : options_(options), leaky_slope_(network.leaky_slope) {
  stem_ = Load(network.stem);
  for (const FoldedBlock& block : network.blocks) {
    blocks_.push_back({{}, block.skip, block.final_activation});
    for (const auto& part : block.convolutions) blocks_.back().convolutions.push_back(Load(part));
  }
  value_convolution_ = Load(network.value_convolution);
  value_hidden_ = Load(network.value_hidden);
  value_output_ = Load(network.value_output);
  policy_convolution_ = Load(network.policy_convolution);
  policy_output_ = Load(network.policy_output);
  foretells_ = network.others_hidden.outputs > 0;
  if (foretells_) {
    others_hidden_ = Load(network.others_hidden);
    others_policy_ = Load(network.others_policy);
  }
  has_own_head_ = network.own_hidden.outputs > 0;
  if (!has_own_head_) return;
  own_hidden_ = Load(network.own_hidden);
  own_value_ = Load(network.own_value);
  own_policy_ = Load(network.own_policy);
}

torch::Tensor InferenceNetwork::Forward(const torch::Tensor& planes) const {
  const torch::Tensor input = ToInput(planes);
  torch::Tensor x = Activate(Run(stem_, input));
  for (const BlockLayers& block : blocks_) x = Run(block, x);
  torch::Tensor policy = Run(policy_output_, Activate(Run(policy_convolution_, x)));
  torch::Tensor hidden = Run(value_hidden_, Activate(Run(value_convolution_, x)));
  if (has_own_head_) {
    const torch::Tensor own = OwnFeatures(x, input);
    hidden += Run(own_value_, own);
    policy += Run(own_policy_, own);
  }
  const torch::Tensor value = Run(value_output_, Activate(hidden));
  return torch::cat(
      {policy.to(torch::kFloat32).softmax(1), value.to(torch::kFloat32).tanh(), Others(x, input)},
      1);
}

torch::Tensor InferenceNetwork::Tensor(const std::vector<float>& values,
                                       torch::IntArrayRef shape) const {
  return torch::tensor(values, torch::kFloat32).reshape(shape).to(options_);
}
InferenceNetwork::Convolution InferenceNetwork::Load(const FoldedConvolution& layer) const {
  const torch::Tensor weights = Tensor(
      layer.weights, {layer.outputs, layer.inputs / layer.groups, layer.kernel, layer.kernel});
  return {weights.contiguous(torch::MemoryFormat::ChannelsLast),
          Tensor(layer.bias, {layer.outputs}), layer.stride, layer.kernel / 2, layer.groups};
}
InferenceNetwork::Linear InferenceNetwork::Load(const LinearLayer& layer) const {
  Linear linear{Tensor(layer.weights, {layer.outputs, layer.inputs}), {}};
  if (!layer.bias.empty()) linear.bias = Tensor(layer.bias, {layer.outputs});
  return linear;
}

torch::Tensor InferenceNetwork::ToInput(const torch::Tensor& planes) const {
  return planes.to(options_).contiguous(torch::MemoryFormat::ChannelsLast);
}
torch::Tensor InferenceNetwork::Activate(torch::Tensor x) const {
  return torch::leaky_relu_(x, leaky_slope_);
}
torch::Tensor InferenceNetwork::Run(const Convolution& layer, const torch::Tensor& x) {
  return torch::conv2d(x, layer.weights, layer.bias, layer.stride, layer.padding,
                       /*dilation=*/1, layer.groups);
}
torch::Tensor InferenceNetwork::Run(const Linear& layer, const torch::Tensor& x) {
  return torch::linear(x.flatten(1), layer.weights, layer.bias);
}
torch::Tensor InferenceNetwork::Run(const BlockLayers& block, const torch::Tensor& input) const {
  torch::Tensor x = input;
  for (std::size_t i = 0; i < block.convolutions.size(); ++i) {
    x = Run(block.convolutions[i], x);
    if (i + 1 < block.convolutions.size()) x = Activate(x);
  }
  if (block.skip) x += input;
  return block.final_activation ? Activate(x) : x;
}

torch::Tensor InferenceNetwork::Others(const torch::Tensor& tower,
                                       const torch::Tensor& input) const {
  if (!foretells_) {
    return torch::zeros({input.size(0), (kAgentCount - 1) * kActionCount},
                        input.options().dtype(torch::kFloat32));
  }
  const torch::Tensor marked =
      input.slice(/*dim=*/1, kOwnCellPlane + 1, kOwnCellPlane + kAgentCount).flatten(2);
  const torch::Tensor channels = marked.matmul(tower.flatten(2).transpose(1, 2));
  const torch::Tensor hidden =
      Activate(torch::linear(channels, others_hidden_.weights, others_hidden_.bias));
  const torch::Tensor logits = torch::linear(hidden, others_policy_.weights, others_policy_.bias);
  const torch::Tensor seen = marked.sum(2, /*keepdim=*/true).to(torch::kFloat32);
  return (logits.to(torch::kFloat32).softmax(2) * seen).flatten(1);
}

torch::Tensor InferenceNetwork::OwnFeatures(const torch::Tensor& tower,
                                            const torch::Tensor& input) const {
  const torch::Tensor marked = input.slice(/*dim=*/1, kOwnCellPlane, kOwnCellPlane + 1);
  return Activate(Run(own_hidden_, (tower * marked).sum({2, 3}))) * marked.sum({2, 3});
}

}  // namespace powderkeg

#include "common/model/folded_network.h"

#include <cmath>

namespace powderkeg {
namespace {

// y = gamma (w x - mean) / sqrt(variance + epsilon) + beta
//   = (gamma / deviation) w x + (beta - mean gamma / deviation).
void FoldBatchNorm(const WeightsSnapshot& snapshot, const std::string& norm,
                   FoldedConvolution& convolution) {
  const std::vector<float>& gamma = snapshot.Array(norm + ".weight").values;
  const std::vector<float>& beta = snapshot.Array(norm + ".bias").values;
  const std::vector<float>& mean = snapshot.Array(norm + ".running_mean").values;
  const std::vector<float>& variance = snapshot.Array(norm + ".running_var").values;
  const std::size_t fan_in = convolution.weights.size() / gamma.size();
  for (std::size_t output = 0; output < gamma.size(); ++output) {
    const float scale = gamma[output] / std::sqrt(variance[output] + kBatchNormEpsilon);
    for (std::size_t i = 0; i < fan_in; ++i) convolution.weights[output * fan_in + i] *= scale;
    convolution.bias.push_back(beta[output] - mean[output] * scale);
  }
}

FoldedConvolution FoldConvolution(const WeightsSnapshot& snapshot, const std::string& prefix,
                                  const std::string& suffix, int stride) {
  const NamedArray& weights = snapshot.Array(prefix + "conv" + suffix + ".weight");
  FoldedConvolution convolution;
  convolution.outputs = static_cast<int>(weights.shape[0]);
  convolution.kernel = static_cast<int>(weights.shape[2]);
  convolution.stride = stride;
  convolution.inputs = static_cast<int>(weights.shape[1]);
  convolution.weights = weights.values;
  FoldBatchNorm(snapshot, prefix + "bn" + suffix, convolution);
  return convolution;
}

// The depthwise convolution of the same arrays, whose weights are [channels][1][3][3].
FoldedConvolution MakeDepthwise(FoldedConvolution convolution) {
  convolution.inputs = convolution.outputs;
  convolution.groups = convolution.outputs;
  return convolution;
}

LinearLayer Matrix(const WeightsSnapshot& snapshot, const std::string& name) {
  const NamedArray& weights = snapshot.Array(name + ".weight");
  return {.inputs = static_cast<int>(weights.shape[1]),
          .outputs = static_cast<int>(weights.shape[0]),
          .weights = weights.values,
          .bias = {}};
}

LinearLayer Linear(const WeightsSnapshot& snapshot, const std::string& name) {
  LinearLayer layer = Matrix(snapshot, name);
  layer.bias = snapshot.Array(name + ".bias").values;
  return layer;
}

FoldedBlock FoldBlock(const WeightsSnapshot& snapshot, const std::string& prefix, int inputs,
                      const BlockDescription& block) {
  FoldedBlock folded;
  folded.skip = HasSkip(block, inputs);
  if (block.kind == BlockDescription::Kind::kResidual) {
    folded.convolutions.push_back(FoldConvolution(snapshot, prefix, "1", block.stride));
    folded.convolutions.push_back(FoldConvolution(snapshot, prefix, "2", /*stride=*/1));
    folded.final_activation = true;
  } else {
    folded.convolutions.push_back(FoldConvolution(snapshot, prefix, "1", /*stride=*/1));
    folded.convolutions.push_back(
        MakeDepthwise(FoldConvolution(snapshot, prefix, "2", block.stride)));
    folded.convolutions.push_back(FoldConvolution(snapshot, prefix, "3", /*stride=*/1));
  }
  return folded;
}

}  // namespace

FoldedNetwork Fold(const WeightsSnapshot& snapshot) {
  const NetworkDescription& description = snapshot.description;
  FoldedNetwork network;
  network.leaky_slope = description.leaky_slope;
  network.stem = FoldConvolution(snapshot, "stem.", "", description.stem_stride);
  int channels = description.stem_channels;
  for (std::size_t i = 0; i < description.blocks.size(); ++i) {
    const BlockDescription& block = description.blocks[i];
    network.blocks.push_back(FoldBlock(snapshot, StrCat("blocks.", i, "."), channels, block));
    channels = block.channels;
  }
  network.value_convolution = FoldConvolution(snapshot, "value.", "", /*stride=*/1);
  network.value_hidden = Linear(snapshot, "value.fc1");
  network.value_output = Linear(snapshot, "value.fc2");
  network.policy_convolution = FoldConvolution(snapshot, "policy.", "", /*stride=*/1);
  network.policy_output = Linear(snapshot, "policy.fc");
  if (description.own_hidden > 0) {
    network.own_hidden = Linear(snapshot, "own.fc");
    network.own_value = Matrix(snapshot, "own.value");
    network.own_policy = Matrix(snapshot, "own.policy");
  }
  if (description.others_hidden > 0) {
    network.others_hidden = Linear(snapshot, "others.fc");
    network.others_policy = Linear(snapshot, "others.policy");
  }
  return network;
}

}  // namespace powderkeg

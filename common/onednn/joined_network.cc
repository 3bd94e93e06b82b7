#include "common/onednn/joined_network.h"

#include <algorithm>

namespace powderkeg::onednn {

JoinedNetwork JoinHeads(const FoldedNetwork& network) {
  const FoldedConvolution& value = network.value_convolution;
  const FoldedConvolution& policy = network.policy_convolution;
  JoinedNetwork joined{.stem = network.stem,
                       .blocks = network.blocks,
                       .head_convolution = value,
                       .head = {},
                       .needs_tower = network.own_hidden.outputs + network.others_hidden.outputs > 0,
                       .leaky_slope = network.leaky_slope};
  FoldedConvolution& convolution = joined.head_convolution;
  convolution.outputs += policy.outputs;
  convolution.weights.insert(convolution.weights.end(), policy.weights.begin(),
                             policy.weights.end());
  convolution.bias.insert(convolution.bias.end(), policy.bias.begin(), policy.bias.end());

  const LinearLayer& hidden = network.value_hidden;
  const LinearLayer& logits = network.policy_output;
  LinearLayer& head = joined.head;
  head.inputs = hidden.inputs + logits.inputs;
  head.outputs = hidden.outputs + logits.outputs;
  head.weights.assign(static_cast<std::size_t>(head.inputs * head.outputs), 0.0F);
  auto row = head.weights.begin();
  for (int output = 0; output < hidden.outputs; ++output, row += head.inputs) {
    std::copy_n(hidden.weights.begin() + output * hidden.inputs, hidden.inputs, row);
  }
  for (int output = 0; output < logits.outputs; ++output, row += head.inputs) {
    std::copy_n(logits.weights.begin() + output * logits.inputs, logits.inputs,
                row + hidden.inputs);
  }
  head.bias = hidden.bias;
  head.bias.insert(head.bias.end(), logits.bias.begin(), logits.bias.end());
  return joined;
}

}  // namespace powderkeg::onednn

#pragma once

// A network as oneDNN evaluates it. Internal to common/onednn.

#include <vector>

#include "common/model/folded_network.h"

namespace powderkeg::onednn {

// A folded network whose two heads are one: their 1x1 convolutions side by side, then one linear
// layer with the value's hidden layer (before its activation) and the policy's logits side by side.
// What one head does not read of the other's channels has weight 0. The heads of single
// cells, the value's output layer, tanh and softmax are left to the caller.
struct JoinedNetwork {
  FoldedConvolution stem;
  std::vector<FoldedBlock> blocks;
  FoldedConvolution head_convolution;
  LinearLayer head;          // outputs: value_hidden, then 6 logits
  bool needs_tower = false;  // whether the caller reads Program::tower()
  float leaky_slope = 0;
};
[[nodiscard]] JoinedNetwork JoinHeads(const FoldedNetwork& network);

}  // namespace powderkeg::onednn

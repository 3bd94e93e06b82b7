#pragma once

// A network for inference: batch norm folded into the convolution before it.

#include <vector>

#include "common/model/weights_snapshot.h"

namespace powderkeg {

// Square kernel; pads with kernel / 2 rings of zeros.
struct FoldedConvolution {
  int inputs = 0;
  int outputs = 0;
  int kernel = 1;              // 1 or 3
  int stride = 1;              // 1 or 2
  int groups = 1;              // 1, or `inputs` (depthwise)
  std::vector<float> weights;  // [outputs][inputs / groups][kernel][kernel]
  std::vector<float> bias;     // [outputs]
};

struct LinearLayer {
  int inputs = 0;
  int outputs = 0;
  std::vector<float> weights;  // [outputs][inputs]
  std::vector<float> bias;     // [outputs], or empty: 0
};

// Activation after each convolution but the last; then the sum with the block's input (if skip);
// then another activation (if final_activation).
struct FoldedBlock {
  std::vector<FoldedConvolution> convolutions;
  bool skip = false;
  bool final_activation = false;
};

// The same function as the network of the snapshot in evaluation mode; see NetworkDescription for
// how the parts are put together.
struct FoldedNetwork {
  FoldedConvolution stem;
  std::vector<FoldedBlock> blocks;
  FoldedConvolution value_convolution;
  LinearLayer value_hidden;
  LinearLayer value_output;
  FoldedConvolution policy_convolution;
  LinearLayer policy_output;
  // The own head and the one that foretells the others, or layers without outputs.
  LinearLayer own_hidden;
  LinearLayer own_value;
  LinearLayer own_policy;
  LinearLayer others_hidden;
  LinearLayer others_policy;
  float leaky_slope = 0;
};

// Requires a valid snapshot.
[[nodiscard]] FoldedNetwork Fold(const WeightsSnapshot& snapshot);

}  // namespace powderkeg

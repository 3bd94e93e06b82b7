#pragma once

// The convolutions of a network forwards and backwards in training mode, for CPUs: what LibTorch
// does operation by operation, in two passes over memory a layer. Products in bf16 and sums in
// fp32, as autocast has them; activations and gradients are kept in bf16, statistics in fp64.
//
// A layer is a convolution, batch norm by the statistics of the batch, the sum with an earlier
// value where there is a skip connection, and LeakyReLU where one follows. Stored of it is the raw
// result of the convolution: whoever reads it applies norm and activation, and its gradient's
// passage through both is done by whoever makes that gradient. Values that are summed are stored
// besides.

#include <functional>
#include <memory>
#include <span>

#include "common/model/network_description.h"

namespace powderkeg {

// One convolution with its norm, and where its gradients are added to. [channel] each, the weights
// [output][input][row][column].
struct ConvolutionParameters {
  const float* weights;
  const float* norm_weights;
  const float* norm_biases;
  float* running_mean;  // these two are moved a tenth towards those of the batch
  float* running_variance;
  float* weights_gradient;
  float* norm_weights_gradient;
  float* norm_biases_gradient;
};

// What the linear layers of the heads read, or the gradients of that.
template <typename Float>
struct HeadArrays {
  Float* value;   // [positions][value channel][cell]
  Float* policy;  // [positions][policy channel][cell]
  // [positions][4][channel], what the tower has of the cells of viewer, viewer + 1, + 2, + 3
  // (planes.h); 0 of who is not marked. Null where the network has neither head that asks for it.
  Float* marked;
  int channels;  // of `marked`
};

// Runs the function once for each of 0 to count - 1, side by side or not.
using ForEachWorker = std::function<void(int count, const std::function<void(int)>& work)>;

// Not thread-safe; threads come in by `for_each`.
class FusedTower {
 public:
  // Whether this processor can, and there is code for such a network: AVX-512 with bf16; channels
  // of the tower in multiples of 16; no 3x3 convolution over all channels has a stride.
  [[nodiscard]] static bool CanRun(const NetworkDescription& network);

  // Requires CanRun(network). The batch is shared out among so many workers; their number changes
  // the last bits of sums.
  FusedTower(const NetworkDescription& network, int workers, ForEachWorker for_each);
  ~FusedTower();
  FusedTower(const FusedTower&) = delete;
  FusedTower& operator=(const FusedTower&) = delete;

  // planes: [positions][23][row][column]; good until Backward. `parameters`: all convolutions in
  // the order of ArraysOf. The results are good until the next call.
  HeadArrays<float> Forward(int positions, const float* planes,
                            std::span<const ConvolutionParameters> parameters);

  // Of the last Forward, with its parameters unchanged: adds the gradients of all of them.
  void Backward(const HeadArrays<const float>& gradients,
                std::span<const ConvolutionParameters> parameters);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace powderkeg

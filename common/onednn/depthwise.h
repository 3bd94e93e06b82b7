#pragma once

// The depthwise convolution of bf16 networks, in AVX-512: twice as fast as oneDNN's, which converts
// each activation to fp32 nine times. Internal to common/onednn.

#include <cstdint>
#include <vector>

#include "common/model/folded_network.h"

namespace powderkeg::onednn {

// A value. Immutable, so that threads may share it.
class DepthwiseKernel {
 public:
  // Whether the processor has what it takes, and the layer is one: kernel 3, an input per output,
  // channels in multiples of 32.
  [[nodiscard]] static bool CanRun(const FoldedConvolution& layer);

  // Requires CanRun(layer). `negative_slope` of the activation that follows, up to 1 (1: none).
  DepthwiseKernel(const FoldedConvolution& layer, float negative_slope);

  // bf16, [positions][row][column][channel] both: `side` rows and columns in, (side - 1) / stride +
  // 1 out. Sums in fp32.
  void Run(int positions, int side, const std::uint16_t* source, std::uint16_t* result) const;

 private:
  // Of one position.
  void RunRow(int row, int side, const std::uint16_t* source, std::uint16_t* result) const;

  int channels_;
  int stride_;
  float negative_slope_;
  std::vector<float> taps_;           // [row][column][channel]
  std::vector<float> bias_;           // [channel]
  std::vector<std::uint16_t> zeros_;  // [channel]: beyond the edge
};

}  // namespace powderkeg::onednn

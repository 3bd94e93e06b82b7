#pragma once

// A network in 8-bit integers. Internal to common/onednn.
//
// Every activation is step * q, q in [-127, 127], with a step per channel; every weight is
// step * q with a step per output. The step of an input channel is multiplied into the weights that
// read it, so a convolution sums whole numbers and multiplies each output's sum by one float
// (Jacob et al. 2018, section 2, with steps per channel for activations too). Steps come from the
// largest activations over fixed positions: the same weights always give the same integers.

#include <oneapi/dnnl/dnnl.hpp>
#include <vector>

#include "common/onednn/joined_network.h"

namespace powderkeg::onednn {

// Planes are in [-1, 1].
inline constexpr float kStepsPerPlane = 127;

// [convolution][output channel], the stem first and the heads' last.
using PerChannel = std::vector<std::vector<float>>;

struct QuantizedNetwork {
  // Weights are whole numbers in [-127, 127], biases are in units of the sums; but for the linear
  // layer, which stays as it is.
  JoinedNetwork network;
  // What the sums of each convolution are multiplied by: the step of its sums over that of its
  // outputs. The outputs of the last one are floats.
  PerChannel scales;
  std::vector<float> tower_steps;  // [channel], of what comes out of the last block
};

// `largest`: the largest absolute value of each channel after each convolution's activation.
[[nodiscard]] QuantizedNetwork Quantize(const JoinedNetwork& network, PerChannel largest);

// What Quantize wants, over positions from games of rule-based agents. Takes the time of some
// hundred evaluations in fp32.
[[nodiscard]] PerChannel LargestActivations(const JoinedNetwork& network,
                                            const dnnl::engine& engine);

}  // namespace powderkeg::onednn

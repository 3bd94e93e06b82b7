#include "common/onednn/quantization.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "common/model/planes.h"
#include "common/onednn/onednn_program.h"
#include "common/policies/policy.h"
#include "common/pommerman/generate.h"
#include "common/pommerman/step.h"

namespace powderkeg::onednn {
namespace {

constexpr float kLargestInteger = 127;
// A channel's step is at least this share of the largest one of its layer: a channel that hardly
// ever speaks would else blow up the weights that read it.
constexpr float kSmallestShare = 1.0F / 64;
// Over the largest activation seen: positions to come may go a little further.
constexpr float kHeadroom = 1.1F;

constexpr int kPositions = 96;
constexpr int kStepsBetween = 7;
constexpr int kBatch = 8;
static_assert(kPositions % kBatch == 0, "a batch that is not full would be left out");

float LargestOf(std::span<const float> values) {
  float largest = 0;
  for (const float value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

std::vector<float> StepsFor(std::vector<float> largest) {
  const float floor = std::max(LargestOf(largest) * kSmallestShare, 1e-6F);
  for (float& value : largest) value = std::max(value, floor) * kHeadroom / kLargestInteger;
  return largest;
}

// A block's output is added to its input, so they share their steps.
void ShareAlongSkips(const std::vector<FoldedBlock>& blocks, PerChannel& largest) {
  const auto last_of = [&](std::size_t block) {  // the convolution whose output is the block's
    std::size_t last = 0;
    for (std::size_t i = 0; i <= block; ++i) last += blocks[i].convolutions.size();
    return last;
  };
  const auto share = [&](std::size_t block) {
    if (!blocks[block].skip) return;
    std::vector<float>& output = largest[last_of(block)];
    std::vector<float>& input = largest[last_of(block) - blocks[block].convolutions.size()];
    for (std::size_t c = 0; c < output.size(); ++c) {
      output[c] = input[c] = std::max(output[c], input[c]);
    }
  };
  for (std::size_t block = 0; block < blocks.size(); ++block) share(block);
  for (std::size_t block = blocks.size(); block-- > 0;) share(block);
}

// Makes weights and biases whole; returns what the sums are to be multiplied by.
std::vector<float> QuantizeLayer(std::span<const float> input_steps,
                                 std::span<const float> output_steps, FoldedConvolution& layer) {
  const auto area = static_cast<std::size_t>(layer.kernel) * static_cast<std::size_t>(layer.kernel);
  const auto outputs = static_cast<std::size_t>(layer.outputs);
  const std::size_t fan_in = layer.weights.size() / outputs;
  std::vector<float> scales(outputs);
  for (std::size_t output = 0; output < outputs; ++output) {
    const std::span<float> weights(&layer.weights[output * fan_in], fan_in);
    for (std::size_t i = 0; i < fan_in; ++i) {
      weights[i] *= input_steps[layer.groups == 1 ? i / area : output];
    }
    const float largest = LargestOf(weights);
    const float step = largest > 0 ? largest / kLargestInteger : 1.0F;
    for (float& weight : weights) weight = std::nearbyint(weight / step);
    layer.bias[output] /= step;
    scales[output] = step / output_steps[output];
  }
  return scales;
}

// Calls visit(position) for kPositions positions of games among rule-based agents.
template <typename Visit>
void VisitPositions(Visit&& visit) {
  const GameSettings settings;
  Rng rng(1);
  std::array<PolicyMemory, kAgentCount> memories{};
  State state = GenerateStart(settings, {}, rng.Split(0));
  for (int made = 0; made < kPositions;) {
    JointAction actions{};
    for (AgentId agent = 0; agent < kAgentCount; ++agent) {
      const auto id = static_cast<std::size_t>(agent);
      if (!state.agents[id].alive) continue;
      if (state.step % kStepsBetween == 0 && made < kPositions) {
        visit(Position{.state = &state, .viewer = agent});
        ++made;
      }
      actions[id] =
          Decide(PolicyKind::kSimpleUnbiased, {state, settings, agent}, {}, memories[id], rng);
    }
    if (!Advance(settings, actions, state).done) continue;
    memories = {};
    state = GenerateStart(settings, {}, rng.Split(static_cast<std::uint64_t>(made)));
  }
}

void TakeLargest(const dnnl::memory& activations, std::vector<float>& largest) {
  const dnnl::engine engine = activations.get_engine();
  const dnnl::memory::dims dims = activations.get_desc().dims();
  const std::size_t channels = static_cast<std::size_t>(dims[1]);
  std::vector<float> values(static_cast<std::size_t>(dims[0] * dims[2] * dims[3]) * channels);
  dnnl::memory plain({dims, dnnl::memory::data_type::f32, dnnl::memory::format_tag::nhwc}, engine,
                     values.data());
  dnnl::stream stream(engine);
  dnnl::memory source = activations;
  dnnl::reorder(source, plain).execute(stream, source, plain);
  stream.wait();
  largest.resize(channels);
  for (std::size_t i = 0; i < values.size(); ++i) {
    largest[i % channels] = std::max(largest[i % channels], std::abs(values[i]));
  }
}

}  // namespace

QuantizedNetwork Quantize(const JoinedNetwork& network, PerChannel largest) {
  ShareAlongSkips(network.blocks, largest);
  QuantizedNetwork quantized{.network = network, .scales = {}, .tower_steps = {}};
  JoinedNetwork& whole = quantized.network;
  std::vector<float> input(static_cast<std::size_t>(whole.stem.inputs), 1.0F / kStepsPerPlane);
  const auto next = [&](FoldedConvolution& layer) {
    std::vector<float> output = StepsFor(largest[quantized.scales.size()]);
    quantized.scales.push_back(QuantizeLayer(input, output, layer));
    input = std::move(output);
  };
  next(whole.stem);
  for (FoldedBlock& block : whole.blocks) {
    for (FoldedConvolution& layer : block.convolutions) next(layer);
  }
  quantized.tower_steps = input;
  const std::vector<float> floats(static_cast<std::size_t>(whole.head_convolution.outputs), 1.0F);
  quantized.scales.push_back(QuantizeLayer(input, floats, whole.head_convolution));
  return quantized;
}

PerChannel LargestActivations(const JoinedNetwork& network, const dnnl::engine& engine) {
  Program program(network, kBatch, dnnl::memory::data_type::f32, engine);
  PerChannel largest;
  int filled = 0;
  VisitPositions([&](const Position& position) {
    const std::span<float> planes =
        program.input().subspan(static_cast<std::size_t>(filled) * kPlanesSize, kPlanesSize);
    EncodePlanes({}, position, planes.first<kPlanesSize>());
    if (++filled < kBatch) return;
    filled = 0;
    program.Run([&](std::size_t convolution, const dnnl::memory& activations) {
      largest.resize(std::max(largest.size(), convolution + 1));
      TakeLargest(activations, largest[convolution]);
    });
  });
  return largest;
}

}  // namespace powderkeg::onednn

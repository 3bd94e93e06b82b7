#include "tests/model/reference_evaluator.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/model/planes.h"

namespace powderkeg {
namespace {

// [channel][row][column]
struct Image {
  int channels = 0;
  int side = 0;
  std::vector<float> values;

  Image(int channels_in, int side_in)
      : channels(channels_in),
        side(side_in),
        values(static_cast<std::size_t>(channels * side * side), 0.0F) {}
  float* Channel(int channel) { return values.data() + channel * side * side; }
  [[nodiscard]] const float* Channel(int channel) const {
    return values.data() + channel * side * side;
  }
};

// One evaluation of one position.
class Forward {
 public:
  explicit Forward(const WeightsSnapshot& snapshot) : snapshot_(snapshot) {}

  Evaluation Run(const Image& planes) {
    const NetworkDescription& description = snapshot_.description;
    Image x = ConvolutionAndNorm(planes, "stem.", "", description.stem_stride);
    Activate(x.values);
    for (std::size_t i = 0; i < description.blocks.size(); ++i) {
      x = Block(x, "blocks." + std::to_string(i) + ".", description.blocks[i]);
    }
    Image value = ConvolutionAndNorm(x, "value.", "", 1);
    Activate(value.values);
    std::vector<float> hidden = Linear(value.values, "value.fc1");
    Image policy = ConvolutionAndNorm(x, "policy.", "", 1);
    Activate(policy.values);
    std::vector<float> logits = Linear(policy.values, "policy.fc");
    if (description.own_hidden > 0) AddOwnHead(planes, x, hidden, logits);
    Activate(hidden);
    Evaluation evaluation{};
    evaluation.value = std::tanh(Linear(hidden, "value.fc2")[0]);
    float sum = 0.0F;
    for (const float logit : logits) sum += std::exp(logit);
    for (std::size_t i = 0; i < kActionCount; ++i) {
      evaluation.policy[i] = std::exp(logits[i]) / sum;
    }
    if (description.others_hidden > 0) Foretell(planes, x, evaluation);
    return evaluation;
  }

 private:
  void Activate(std::vector<float>& values) const {
    for (float& value : values) {
      value = value > 0.0F ? value : value * snapshot_.description.leaky_slope;
    }
  }

  [[nodiscard]] Image ConvolutionAndNorm(const Image& input, const std::string& prefix,
                                         const std::string& suffix, int stride) const {
    const NamedArray& weights = snapshot_.Array(prefix + "conv" + suffix + ".weight");
    const auto kernel = static_cast<int>(weights.shape[2]);
    const auto inputs = static_cast<int>(weights.shape[1]);
    const auto outputs = static_cast<int>(weights.shape[0]);
    Image result(outputs, (input.side - 1) / stride + 1);
    for (int output = 0; output < outputs; ++output) {
      for (int i = 0; i < inputs; ++i) {
        const float* const filter =
            &weights.values[static_cast<std::size_t>((output * inputs + i) * kernel * kernel)];
        Accumulate(input.Channel(inputs < input.channels ? output : i), input.side, filter, kernel,
                   stride, result.Channel(output), result.side);
      }
    }
    Normalise(prefix + "bn" + suffix + ".", result);
    return result;
  }

  static void Accumulate(const float* input, int side, const float* filter, int kernel, int stride,
                         float* output, int output_side) {
    for (int position = 0; position < output_side * output_side; ++position) {
      const int row = position / output_side * stride - kernel / 2;
      const int column = position % output_side * stride - kernel / 2;
      for (int k = 0; k < kernel * kernel; ++k) {
        const int r = row + k / kernel;
        const int c = column + k % kernel;
        if (r < 0 || r >= side || c < 0 || c >= side) continue;
        output[position] += filter[k] * input[r * side + c];
      }
    }
  }

  void Normalise(const std::string& prefix, Image& image) const {
    for (int channel = 0; channel < image.channels; ++channel) {
      const auto i = static_cast<std::size_t>(channel);
      const float mean = snapshot_.Array(prefix + "running_mean").values[i];
      const float variance = snapshot_.Array(prefix + "running_var").values[i];
      const float gamma = snapshot_.Array(prefix + "weight").values[i];
      const float beta = snapshot_.Array(prefix + "bias").values[i];
      float* const values = image.Channel(channel);
      for (int cell = 0; cell < image.side * image.side; ++cell) {
        values[cell] =
            (values[cell] - mean) / std::sqrt(variance + kBatchNormEpsilon) * gamma + beta;
      }
    }
  }

  [[nodiscard]] Image Block(const Image& input, const std::string& prefix,
                            const BlockDescription& block) const {
    const bool residual = block.kind == BlockDescription::Kind::kResidual;
    Image x = ConvolutionAndNorm(input, prefix, "1", residual ? block.stride : 1);
    Activate(x.values);
    x = ConvolutionAndNorm(x, prefix, "2", residual ? 1 : block.stride);
    if (!residual) {
      Activate(x.values);
      x = ConvolutionAndNorm(x, prefix, "3", 1);
    }
    if (block.stride == 1 && input.channels == x.channels) {
      for (std::size_t i = 0; i < x.values.size(); ++i) x.values[i] += input.values[i];
    }
    if (residual) Activate(x.values);
    return x;
  }

  void AddOwnHead(const Image& planes, const Image& tower, std::vector<float>& hidden,
                  std::vector<float>& logits) const {
    const float* const own_cell = planes.Channel(kOwnCellPlane);
    for (int cell = 0; cell < kCellCount; ++cell) {
      if (own_cell[cell] == 0.0F) continue;
      std::vector<float> own;
      for (int channel = 0; channel < tower.channels; ++channel) {
        own.push_back(tower.Channel(channel)[cell]);
      }
      own = Linear(own, "own.fc");
      Activate(own);
      AddProduct(snapshot_.Array("own.value.weight"), own, hidden);
      AddProduct(snapshot_.Array("own.policy.weight"), own, logits);
    }
  }

  void Foretell(const Image& planes, const Image& tower, Evaluation& evaluation) const {
    for (int other = 0; other < kAgentCount - 1; ++other) {
      const float* const marked = planes.Channel(kOwnCellPlane + 1 + other);
      const auto cell = std::find(marked, marked + kCellCount, 1.0F) - marked;
      if (cell == kCellCount) continue;
      std::vector<float> features;
      for (int channel = 0; channel < tower.channels; ++channel) {
        features.push_back(tower.Channel(channel)[cell]);
      }
      features = Linear(features, "others.fc");
      Activate(features);
      std::vector<float> logits = Linear(features, "others.policy");
      float sum = 0.0F;
      for (float& logit : logits) sum += logit = std::exp(logit);
      for (std::size_t i = 0; i < kActionCount; ++i) {
        evaluation.others[static_cast<std::size_t>(other)][i] = InWholes(logits[i] / sum);
      }
    }
  }

  static void AddProduct(const NamedArray& weights, const std::vector<float>& input,
                         std::vector<float>& output) {
    for (std::size_t o = 0; o < output.size(); ++o) {
      for (std::size_t i = 0; i < input.size(); ++i) {
        output[o] += weights.values[o * input.size() + i] * input[i];
      }
    }
  }

  [[nodiscard]] std::vector<float> Linear(const std::vector<float>& input,
                                          const std::string& name) const {
    std::vector<float> output = snapshot_.Array(name + ".bias").values;
    AddProduct(snapshot_.Array(name + ".weight"), input, output);
    return output;
  }

  const WeightsSnapshot& snapshot_;
};

}  // namespace

void ReferenceEvaluator::Evaluate(const GameSettings& settings, std::span<const Position> positions,
                                  std::span<Evaluation> evaluations) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    Image planes(kPlaneCount, kBoardSize);
    EncodePlanes(settings, positions[i],
                 std::span<float, kPlanesSize>(planes.values.data(), kPlanesSize));
    evaluations[i] = Forward(*snapshot_).Run(planes);
  }
}

}  // namespace powderkeg

#include "learner/train/fused_tower.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/model/planes.h"
#include "common/pommerman/types.h"
#include "learner/train/tower_kernels.h"

namespace powderkeg {
namespace {

using tower::Bf16;

constexpr int kChannelBlock = 16;  // the kernels work on so many channels
constexpr int kStemInputs = 24;    // the planes and one of zeros: the kernels read pairs
constexpr double kMomentum = 0.1;  // of the running statistics

using Parameters = std::span<const ConvolutionParameters>;

// An array that begins at a cache line. New elements are 0.
template <typename T>
class Aligned {
 public:
  Aligned() = default;
  explicit Aligned(std::size_t size) { Grow(size); }

  void Grow(std::size_t size) {
    const std::size_t lines = (size * sizeof(T) + sizeof(Line) - 1) / sizeof(Line);
    if (lines > lines_.size()) lines_.resize(lines);
  }
  void Clear() { std::ranges::fill(lines_, Line{}); }
  [[nodiscard]] T* data() { return reinterpret_cast<T*>(lines_.data()); }
  T& operator[](std::size_t i) { return data()[i]; }

 private:
  struct alignas(64) Line {
    std::array<std::byte, 64> bytes{};
  };
  std::vector<Line> lines_;
};

// ---- The layers of a network --------------------------------------------------------------------

struct LayerShape {
  bool depthwise = false;
  int kernel = 3;
  int side = kBoardSize;  // of what it reads
  int stride = 1;
  int given_inputs = 0;  // as its weights have them; `inputs` with those of zeros
  int inputs = 0;
  // The convolutions that it is made of, each with so many outputs; `outputs` with those of zeros.
  std::vector<int> parts = {};
  int outputs = 0;
  bool active = true;
  std::optional<std::size_t> skip = {};  // the layer whose value is added before the activation

  [[nodiscard]] int side_out() const { return (side - 1) / stride + 1; }
  [[nodiscard]] int cells_out() const { return side_out() * side_out(); }
  [[nodiscard]] std::size_t size_out() const {
    return static_cast<std::size_t>(cells_out() * outputs);
  }
  [[nodiscard]] tower::DenseShape dense() const { return {kernel, side, inputs, outputs}; }
  [[nodiscard]] tower::DepthwiseShape by_channel() const { return {side, stride, outputs}; }
  // Weights of one output as they are given, and of all as the kernels have them.
  [[nodiscard]] std::size_t weights_of_output() const {
    return static_cast<std::size_t>(kernel * kernel * (depthwise ? 1 : given_inputs));
  }
  [[nodiscard]] std::size_t weight_count() const {
    return static_cast<std::size_t>(kernel * kernel * (depthwise ? 1 : inputs) * outputs);
  }
};

// Layer i reads the value of layer i - 1, the first one the planes; the last is that of the heads.
std::vector<LayerShape> LayersOf(const NetworkDescription& network) {
  std::vector<LayerShape> layers;
  const auto add = [&](LayerShape layer) {
    if (layers.empty()) {
      layer.given_inputs = network.planes;
      layer.inputs = kStemInputs;
    } else {
      layer.side = layers.back().side_out();
      layer.given_inputs = layer.inputs = layers.back().outputs;
    }
    for (const int part : layer.parts) layer.outputs += part;
    layers.push_back(layer);
  };
  add({.stride = network.stem_stride, .parts = {network.stem_channels}});
  for (const BlockDescription& block : network.blocks) {
    std::optional<std::size_t> skip;
    if (HasSkip(block, layers.back().outputs)) skip = layers.size() - 1;
    if (block.kind == BlockDescription::Kind::kResidual) {
      add({.stride = block.stride, .parts = {block.channels}});
      add({.parts = {block.channels}, .skip = skip});
    } else {
      add({.kernel = 1, .parts = {block.expanded}});
      add({.depthwise = true, .stride = block.stride, .parts = {block.expanded}});
      add({.kernel = 1, .parts = {block.channels}, .active = false, .skip = skip});
    }
  }
  add({.kernel = 1, .parts = {network.value_channels, network.policy_channels}});
  int& outputs = layers.back().outputs;
  outputs = (outputs + kChannelBlock - 1) / kChannelBlock * kChannelBlock;
  return layers;
}

bool HasKernels(const LayerShape& layer) {
  return (layer.depthwise || layer.stride == 1) && layer.outputs % kChannelBlock == 0 &&
         tower::HasSide(layer.side);
}

// ---- What the passes keep -----------------------------------------------------------------------

// Parameters of all parts of a layer, or their gradients; 0 for outputs that no part has.
struct JoinedParameters {
  Aligned<float> weights, norm_weights, norm_biases;

  explicit JoinedParameters(const LayerShape& shape)
      : weights(shape.weight_count()),
        norm_weights(static_cast<std::size_t>(shape.outputs)),
        norm_biases(static_cast<std::size_t>(shape.outputs)) {}
};

// Batch norm in this batch.
struct Norm {
  std::vector<double> mean, inverse_deviation;
  Aligned<float> scale, shift;                   // of the raw result, as it is applied
  Aligned<float> of_gradient, of_raw, constant;  // backwards, see tower::NormGradient

  explicit Norm(std::size_t channels)
      : mean(channels),
        inverse_deviation(channels),
        scale(channels),
        shift(channels),
        of_gradient(channels),
        of_raw(channels),
        constant(channels) {}
};

struct Layer {
  LayerShape shape;
  JoinedParameters parameters, gradients;
  Norm norm;
  bool kept = false;                    // its value is part of a sum, and stored
  std::optional<std::size_t> added_to;  // the layer whose skip connection begins here
  Aligned<Bf16> forwards, backwards;    // packed weights
  Aligned<float> taps, turned_taps;     // of depthwise ones, [tap][channel]
  Aligned<Bf16> raw, value;             // [position][cell][channel]
  Aligned<Bf16> gradient;  // before the activation and the sum, of layers with a skip connection

  explicit Layer(const LayerShape& layer_shape)
      : shape(layer_shape),
        parameters(layer_shape),
        gradients(layer_shape),
        norm(static_cast<std::size_t>(layer_shape.outputs)) {
    if (shape.depthwise) {
      taps.Grow(shape.weight_count());
      turned_taps.Grow(shape.weight_count());
    } else {
      forwards.Grow(shape.weight_count());
      backwards.Grow(shape.weight_count());
    }
  }

  Bf16* In(Aligned<Bf16>& array, int position) const {
    return array.data() + shape.size_out() * static_cast<std::size_t>(position);
  }
};

// Fields that are written again and again: their rings, and the cells that a stride leaves out,
// stay 0.
class FieldShelf {
 public:
  Bf16* Get(int side, int channels, int stride) {
    const std::array<int, 3> shape{side, channels, stride};
    const auto found = std::ranges::find(fields_, shape, &Entry::first);
    if (found != fields_.end()) return found->second.data();
    fields_.emplace_back(shape, Aligned<Bf16>(tower::FieldSize(side, channels)));
    return fields_.back().second.data();
  }

 private:
  using Entry = std::pair<std::array<int, 3>, Aligned<Bf16>>;
  std::vector<Entry> fields_;
};

// What one thread needs for one position at a time, and its sums over positions.
struct Worker {
  FieldShelf values, gradients;
  Aligned<float> result;
  Aligned<std::uint32_t> input_pairs, output_pairs;
  Aligned<double> first_sums, second_sums;
  Aligned<float> weights_gradient;  // [tap][input][output] or, depthwise, [tap][channel]

  void Reserve(const LayerShape& shape) {
    const auto channels = static_cast<std::size_t>(std::max(shape.inputs, shape.outputs));
    result.Grow(static_cast<std::size_t>(shape.side * shape.side) * channels);
    input_pairs.Grow(tower::PairsSize(shape.side, shape.inputs));
    output_pairs.Grow(tower::PairsSize(shape.side, shape.outputs));
    first_sums.Grow(channels);
    second_sums.Grow(channels);
    weights_gradient.Grow(shape.weight_count());
  }
};

void PackWeights(Layer& layer, bool first) {
  const LayerShape& shape = layer.shape;
  float* const weights = layer.parameters.weights.data();
  if (!shape.depthwise) {
    tower::PackForwards(shape.dense(), shape.given_inputs, weights, layer.forwards.data());
    if (!first) tower::PackBackwards(shape.dense(), weights, layer.backwards.data());
    return;
  }
  const auto taps = static_cast<std::size_t>(shape.kernel * shape.kernel);
  const auto channels = static_cast<std::size_t>(shape.outputs);
  for (std::size_t i = 0; i < channels * taps; ++i) {
    const std::size_t tap = i % taps;
    layer.taps[tap * channels + i / taps] = weights[i];
    layer.turned_taps[(taps - 1 - tap) * channels + i / taps] = weights[i];
  }
}

}  // namespace

// ---- The passes ---------------------------------------------------------------------------------

class FusedTower::Implementation {
 public:
  Implementation(const NetworkDescription& network, int workers, ForEachWorker for_each)
      : network_(network),
        for_each_(std::move(for_each)),
        workers_(static_cast<std::size_t>(workers)),
        marked_(network.own_hidden > 0 || network.others_hidden > 0) {
    for (const LayerShape& shape : LayersOf(network)) {
      for (Worker& worker : workers_) worker.Reserve(shape);
      if (shape.skip) {
        layers_[*shape.skip].kept = true;
        layers_[*shape.skip].added_to = layers_.size();
      }
      layers_.emplace_back(shape);
      layers_.back().kept = shape.skip.has_value();
    }
  }

  HeadArrays<float> Forward(int positions, const float* planes, Parameters parameters) {
    positions_ = positions;
    planes_ = planes;
    MakeRoom();
    OverBatch([&](Worker& /*worker*/, int position) {
      tower::FieldOfPlanes(kBoardSize, network_.planes, kStemInputs, PlanesOf(position),
                           PlanesField(position));
    });
    std::size_t part = 0;
    for (std::size_t i = 0; i < layers_.size(); ++i) {
      Layer& layer = layers_[i];
      const Parameters own = parameters.subspan(part, layer.shape.parts.size());
      part += own.size();
      Join(layer, own);
      PackWeights(layer, /*first=*/i == 0);
      OverBatch([&](Worker& worker, int position) {
        const Bf16* const value = ForwardOne(i, worker, position);
        if (i + 1 == layers_.size()) ReadMarked(value, position);
      });
      SetNorm(layer, own);
    }
    CHECK(part == parameters.size());
    OverBatch([&](Worker& worker, int position) { ReadHeads(worker, position); });
    return {value_.data(), policy_.data(), marked_ ? cells_.data() : nullptr,
            layers_.back().shape.inputs};
  }

  void Backward(const HeadArrays<const float>& gradients, Parameters parameters) {
    const std::size_t last = layers_.size() - 1;
    OverBatch([&](Worker& worker, int position) {
      const Bf16* const value = ValueOf(last, worker, position, /*stored=*/true);
      JoinHeads(gradients, worker, position);
      ThroughActivation(last, worker, position, value);
    });
    std::size_t part = parameters.size();
    for (std::size_t i = last + 1; i-- > 0;) {
      Layer& layer = layers_[i];
      SetNormGradient(layer);
      for (Worker& worker : workers_) worker.weights_gradient.Clear();
      OverBatch([&](Worker& worker, int position) {
        const Bf16* const value = BackwardOne(i, worker, position);
        if (i == 0) return;
        if (i == last) AddMarked(gradients.marked, worker, position);
        ThroughActivation(i - 1, worker, position, value);
      });
      SumWeightGradients(layer);
      part -= layer.shape.parts.size();
      Separate(layer, parameters.subspan(part, layer.shape.parts.size()));
    }
  }

 private:
  // ---- Sharing out the batch

  void MakeRoom() {
    const auto positions = static_cast<std::size_t>(positions_);
    for (Layer& layer : layers_) {
      const std::size_t size = layer.shape.size_out() * positions;
      layer.raw.Grow(size);
      if (layer.kept) layer.value.Grow(size);
      if (layer.shape.skip) layer.gradient.Grow(size);
      for (Aligned<Bf16>& gradient : gradients_) gradient.Grow(size);
    }
    const LayerShape& heads = layers_.back().shape;
    plane_fields_.Grow(tower::FieldSize(kBoardSize, kStemInputs) * positions);
    value_.Grow(static_cast<std::size_t>(heads.cells_out() * heads.parts[0]) * positions);
    policy_.Grow(static_cast<std::size_t>(heads.cells_out() * heads.parts[1]) * positions);
    cells_.Grow(static_cast<std::size_t>(kAgentCount * heads.inputs) * positions);
  }

  template <typename Work>
  void OverBatch(Work work) {
    const auto count = static_cast<int>(workers_.size());
    for_each_(count, [&](int index) {
      const auto first = static_cast<int>(std::int64_t{positions_} * index / count);
      const auto end = static_cast<int>(std::int64_t{positions_} * (index + 1) / count);
      Worker& worker = workers_[static_cast<std::size_t>(index)];
      for (int position = first; position < end; ++position) work(worker, position);
    });
  }

  // The sum of all workers for a channel; it begins anew.
  double TakeSum(Aligned<double> Worker::*sums, std::size_t channel) {
    double total = 0;
    for (Worker& worker : workers_) total += std::exchange((worker.*sums)[channel], 0.0);
    return total;
  }

  [[nodiscard]] double CountOf(const LayerShape& shape) const {
    return static_cast<double>(positions_) * shape.cells_out();
  }

  // ---- Parameters

  static void Join(Layer& layer, Parameters given) {
    const std::size_t size = layer.shape.weights_of_output();
    std::size_t first = 0;
    for (std::size_t i = 0; i < given.size(); ++i) {
      const auto count = static_cast<std::size_t>(layer.shape.parts[i]);
      std::copy_n(given[i].weights, count * size, &layer.parameters.weights[first * size]);
      std::copy_n(given[i].norm_weights, count, &layer.parameters.norm_weights[first]);
      std::copy_n(given[i].norm_biases, count, &layer.parameters.norm_biases[first]);
      first += count;
    }
  }

  // The gradients to where they are added; they are 0 then.
  static void Separate(Layer& layer, Parameters given) {
    const std::size_t size = layer.shape.weights_of_output();
    const auto add = [](float*& from, std::size_t count, float* to) {
      for (std::size_t i = 0; i < count; ++i) to[i] += std::exchange(*from++, 0.0F);
    };
    float* weights = layer.gradients.weights.data();
    float* norm_weights = layer.gradients.norm_weights.data();
    float* norm_biases = layer.gradients.norm_biases.data();
    for (std::size_t i = 0; i < given.size(); ++i) {
      const auto count = static_cast<std::size_t>(layer.shape.parts[i]);
      add(weights, count * size, given[i].weights_gradient);
      add(norm_weights, count, given[i].norm_weights_gradient);
      add(norm_biases, count, given[i].norm_biases_gradient);
    }
  }

  // ---- Forwards

  [[nodiscard]] const float* PlanesOf(int position) const {
    return planes_ + static_cast<std::ptrdiff_t>(position) * network_.planes * kCellCount;
  }
  Bf16* PlanesField(int position) {
    return plane_fields_.data() +
           tower::FieldSize(kBoardSize, kStemInputs) * static_cast<std::size_t>(position);
  }

  // Returns what it read.
  const Bf16* ForwardOne(std::size_t index, Worker& worker, int position) {
    Layer& layer = layers_[index];
    const LayerShape& shape = layer.shape;
    const Bf16* const field =
        index == 0 ? PlanesField(position) : ValueOf(index - 1, worker, position, /*stored=*/false);
    if (shape.depthwise) {
      tower::Convolve(shape.by_channel(), field, layer.taps.data(), worker.result.data());
    } else {
      tower::Convolve(shape.dense(), field, layer.forwards.data(), worker.result.data());
    }
    tower::StoreRaw(shape.cells_out(), shape.outputs, worker.result.data(),
                    layer.In(layer.raw, position), worker.first_sums.data(),
                    worker.second_sums.data());
    return field;
  }

  // The value of a layer, in a field of the worker. `stored`: it was made before.
  const Bf16* ValueOf(std::size_t index, Worker& worker, int position, bool stored) {
    Layer& layer = layers_[index];
    const LayerShape& shape = layer.shape;
    Bf16* const field = worker.values.Get(shape.side_out(), shape.outputs, /*stride=*/1);
    if (stored && layer.kept) {
      tower::FieldOf(shape.side_out(), shape.outputs, layer.In(layer.value, position), field);
      return field;
    }
    const Bf16* addend = nullptr;
    if (shape.skip) addend = layers_[*shape.skip].In(layers_[*shape.skip].value, position);
    tower::MakeValue(shape.side_out(), shape.outputs, layer.In(layer.raw, position),
                     {layer.norm.scale.data(), layer.norm.shift.data(), SlopeOf(shape)}, addend,
                     layer.kept ? layer.In(layer.value, position) : nullptr, field);
    return field;
  }

  [[nodiscard]] float SlopeOf(const LayerShape& shape) const {
    return shape.active ? network_.leaky_slope : 1.0F;
  }

  // From the sums of the raw results.
  void SetNorm(Layer& layer, Parameters given) {
    const double count = CountOf(layer.shape);
    Norm& norm = layer.norm;
    std::vector<double> variances(norm.mean.size());
    for (std::size_t i = 0; i < norm.mean.size(); ++i) {
      const double mean = TakeSum(&Worker::first_sums, i) / count;
      variances[i] = std::max(0.0, TakeSum(&Worker::second_sums, i) / count - mean * mean);
      norm.mean[i] = mean;
      norm.inverse_deviation[i] = 1 / std::sqrt(variances[i] + kBatchNormEpsilon);
      const double scale = layer.parameters.norm_weights[i] * norm.inverse_deviation[i];
      norm.scale[i] = static_cast<float>(scale);
      norm.shift[i] = static_cast<float>(layer.parameters.norm_biases[i] - mean * scale);
    }
    const double unbiased = count / std::max(1.0, count - 1);
    std::size_t channel = 0;
    for (std::size_t part = 0; part < given.size(); ++part) {
      for (int i = 0; i < layer.shape.parts[part]; ++i, ++channel) {
        Move(given[part].running_mean[i], norm.mean[channel]);
        Move(given[part].running_variance[i], variances[channel] * unbiased);
      }
    }
  }

  static void Move(float& running, double to) {
    running = static_cast<float>((1 - kMomentum) * running + kMomentum * to);
  }

  // ---- Heads

  void ReadHeads(Worker& worker, int position) {
    const LayerShape& heads = layers_.back().shape;
    const int side = heads.side_out();
    const Bf16* const field = ValueOf(layers_.size() - 1, worker, position, /*stored=*/false);
    tower::PlanesOf(side, heads.outputs, field, 0, heads.parts[0],
                    PartOf(value_.data(), 0, position));
    tower::PlanesOf(side, heads.outputs, field, heads.parts[0], heads.parts[1],
                    PartOf(policy_.data(), 1, position));
  }

  // `tower`: the field of its value.
  void ReadMarked(const Bf16* tower, int position) {
    if (!marked_) return;
    const LayerShape& heads = layers_.back().shape;
    for (int agent = 0; agent < kAgentCount; ++agent) {
      float* const to = MarkedOf(cells_.data(), position, agent);
      std::fill_n(to, heads.inputs, 0.0F);
      if (const std::optional<int> cell = MarkedCell(position, agent)) {
        tower::AddCell(heads.side, heads.inputs, tower, *cell, to);
      }
    }
  }

  template <typename Float>
  Float* PartOf(Float* array, std::size_t part, int position) const {
    const LayerShape& heads = layers_.back().shape;
    return array + std::ptrdiff_t{position} * heads.parts[part] * heads.cells_out();
  }

  template <typename Float>
  Float* MarkedOf(Float* array, int position, int agent) const {
    return array + (std::ptrdiff_t{position} * kAgentCount + agent) * layers_.back().shape.inputs;
  }

  [[nodiscard]] std::optional<int> MarkedCell(int position, int agent) const {
    const float* const plane =
        PlanesOf(position) + static_cast<std::ptrdiff_t>(kOwnCellPlane + agent) * kCellCount;
    const float* const found = std::find(plane, plane + kCellCount, 1.0F);
    if (found == plane + kCellCount) return std::nullopt;
    return static_cast<int>(found - plane);
  }

  // The gradient of the heads' layer into the worker's result.
  void JoinHeads(const HeadArrays<const float>& gradients, Worker& worker, int position) {
    const LayerShape& heads = layers_.back().shape;
    std::fill_n(worker.result.data(), heads.size_out(), 0.0F);
    int channel = 0;
    const auto join = [&](const float* from, int channels) {
      for (int end = channel + channels; channel < end; ++channel) {
        for (int cell = 0; cell < heads.cells_out(); ++cell) {
          worker.result.data()[cell * heads.outputs + channel] = *from++;
        }
      }
    };
    join(PartOf(gradients.value, 0, position), heads.parts[0]);
    join(PartOf(gradients.policy, 1, position), heads.parts[1]);
  }

  // Adds to the worker's result, that of the tower's value.
  void AddMarked(const float* gradients, Worker& worker, int position) {
    if (!marked_) return;
    const int channels = layers_.back().shape.inputs;
    for (int agent = 0; agent < kAgentCount; ++agent) {
      const std::optional<int> cell = MarkedCell(position, agent);
      if (!cell) continue;
      const float* const from = MarkedOf(gradients, position, agent);
      float* const to = worker.result.data() + std::ptrdiff_t{*cell} * channels;
      for (int i = 0; i < channels; ++i) to[i] += from[i];
    }
  }

  // ---- Backwards. The gradients that are stored are those before the activation and the sum.

  Aligned<Bf16>& GradientOf(std::size_t index) {
    Layer& layer = layers_[index];
    return layer.shape.skip ? layer.gradient : gradients_[index % 2];
  }

  // From the worker's result, the gradient of the layer's value as far as the next layer made it.
  void ThroughActivation(std::size_t index, Worker& worker, int position, const Bf16* value) {
    Layer& layer = layers_[index];
    const LayerShape& shape = layer.shape;
    const Bf16* addend = nullptr;
    if (layer.added_to) {
      addend = layers_[*layer.added_to].In(GradientOf(*layer.added_to), position);
    }
    tower::ThroughActivation(shape.side_out(), shape.outputs, worker.result.data(), addend,
                             SlopeOf(shape), value, layer.In(layer.raw, position),
                             layer.In(GradientOf(index), position), worker.first_sums.data(),
                             worker.second_sums.data());
  }

  // With x = (raw - mean) / deviation and g the gradient of weight * x + bias, over M cells, that
  // of raw is weight / deviation * (g - sum(g) / M - x * sum(g x) / M).
  void SetNormGradient(Layer& layer) {
    const double count = CountOf(layer.shape);
    Norm& norm = layer.norm;
    for (std::size_t i = 0; i < norm.mean.size(); ++i) {
      const double inverse = norm.inverse_deviation[i];
      const double sum = TakeSum(&Worker::first_sums, i);
      const double product = (TakeSum(&Worker::second_sums, i) - norm.mean[i] * sum) * inverse;
      layer.gradients.norm_biases[i] = static_cast<float>(sum);
      layer.gradients.norm_weights[i] = static_cast<float>(product);
      const double scale = layer.parameters.norm_weights[i] * inverse;
      const double of_raw = -scale * inverse * product / count;
      norm.of_gradient[i] = static_cast<float>(scale);
      norm.of_raw[i] = static_cast<float>(of_raw);
      norm.constant[i] = static_cast<float>(-scale * sum / count - norm.mean[i] * of_raw);
    }
  }

  // Adds the gradient of the weights to the worker's; that of what the layer read is the result.
  // Returns what it read.
  const Bf16* BackwardOne(std::size_t index, Worker& worker, int position) {
    Layer& layer = layers_[index];
    const LayerShape& shape = layer.shape;
    const Bf16* const read =
        index == 0 ? PlanesField(position) : ValueOf(index - 1, worker, position, /*stored=*/true);
    Bf16* const gradient = worker.gradients.Get(shape.side, shape.outputs, shape.stride);
    tower::ThroughNorm(shape.side_out(), shape.outputs, layer.In(GradientOf(index), position),
                       layer.In(layer.raw, position), NormGradientOf(layer.norm), shape.side,
                       shape.stride, gradient);
    if (shape.depthwise) {
      tower::AddWeightGradient(shape.by_channel(), read, gradient, worker.weights_gradient.data());
      tower::Convolve(tower::DepthwiseShape{shape.side, 1, shape.outputs}, gradient,
                      layer.turned_taps.data(), worker.result.data());
      return read;
    }
    tower::PairNeighbours(shape.dense(), read, worker.input_pairs.data());
    tower::PairGradient(shape.dense(), gradient, worker.output_pairs.data());
    tower::AddWeightGradient(shape.dense(), worker.input_pairs.data(), worker.output_pairs.data(),
                             worker.weights_gradient.data());
    if (index > 0) {
      tower::Convolve(tower::Backwards(shape.dense()), gradient, layer.backwards.data(),
                      worker.result.data());
    }
    return read;
  }

  static tower::NormGradient NormGradientOf(Norm& norm) {
    return {norm.of_gradient.data(), norm.of_raw.data(), norm.constant.data()};
  }

  void SumWeightGradients(Layer& layer) {
    const LayerShape& shape = layer.shape;
    const int taps = shape.kernel * shape.kernel;
    const int inputs = shape.depthwise ? 1 : shape.inputs;
    const int given_inputs = shape.depthwise ? 1 : shape.given_inputs;
    for (Worker& worker : workers_) {
      const float* const sums = worker.weights_gradient.data();
      float* to = layer.gradients.weights.data();
      for (int output = 0; output < shape.outputs; ++output) {
        for (int input = 0; input < given_inputs; ++input) {
          for (int tap = 0; tap < taps; ++tap) {
            *to++ += sums[(tap * inputs + input) * shape.outputs + output];
          }
        }
      }
    }
  }

  NetworkDescription network_;
  ForEachWorker for_each_;
  std::vector<Worker> workers_;
  std::vector<Layer> layers_;
  bool marked_;  // some head asks for the cells of agents
  int positions_ = 0;
  const float* planes_ = nullptr;
  Aligned<Bf16> plane_fields_;
  std::array<Aligned<Bf16>, 2> gradients_;  // of every other layer
  Aligned<float> value_, policy_, cells_;   // see HeadArrays
};

bool FusedTower::CanRun(const NetworkDescription& network) {
  return tower::CanRun() && network.planes <= kStemInputs &&
         std::ranges::all_of(LayersOf(network), HasKernels);
}

FusedTower::FusedTower(const NetworkDescription& network, int workers, ForEachWorker for_each)
    : implementation_(std::make_unique<Implementation>(network, workers, std::move(for_each))) {
  CHECK(CanRun(network));
}

FusedTower::~FusedTower() = default;

HeadArrays<float> FusedTower::Forward(int positions, const float* planes, Parameters parameters) {
  return implementation_->Forward(positions, planes, parameters);
}

void FusedTower::Backward(const HeadArrays<const float>& gradients, Parameters parameters) {
  implementation_->Backward(gradients, parameters);
}

}  // namespace powderkeg

#include "common/torch/torch_evaluator.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "common/base/check.h"
#include "common/model/folded_network.h"
#include "common/model/planes.h"
#include "common/torch/torch_headers.h"
#include "common/torch/torch_runtime.h"

namespace powderkeg {
namespace {

// Larger batches are evaluated in slices: on the CPU the activations then stay in the cache.
constexpr std::size_t kCpuSlice = 32;
constexpr std::size_t kCudaSlice = 4096;

torch::ScalarType ScalarTypeOf(Precision precision) {
  switch (precision) {
    case Precision::kBf16: return torch::kBFloat16;
    case Precision::kFp16: return torch::kFloat16;
    case Precision::kFp32: break;
  }
  return torch::kFloat32;
}

torch::Device DeviceOf(const TorchEvaluatorSettings& settings) {
  if (settings.device == TorchDevice::kCpu) return torch::kCPU;
  return {torch::kCUDA, static_cast<torch::DeviceIndex>(settings.cuda_index)};
}

void Validate(const TorchEvaluatorSettings& settings) {
  if (settings.device == TorchDevice::kCpu && settings.precision == Precision::kFp16) {
    throw Error("torch evaluator: precision fp16 on the cpu, expected fp32 or bf16");
  }
  if (settings.device == TorchDevice::kCpu) return;
  const auto devices = IsCudaAvailable() ? static_cast<int>(torch::cuda::device_count()) : 0;
  if (settings.cuda_index < 0 || settings.cuda_index >= devices) {
    throw Error(
        StrCat("torch evaluator: CUDA device ", settings.cuda_index, " of ", devices, " devices"));
  }
}

// A folded network as tensors of one type on one device; a functional forward pass.
class InferenceNetwork {
 public:
  InferenceNetwork(const FoldedNetwork& network, torch::TensorOptions options)
      : options_(options), leaky_slope_(network.leaky_slope) {
    stem_ = Load(network.stem);
    for (const FoldedBlock& block : network.blocks) {
      blocks_.push_back({{}, block.skip, block.final_activation});
      for (const auto& part : block.convolutions) blocks_.back().convolutions.push_back(Load(part));
    }
    value_convolution_ = Load(network.value_convolution);
    value_hidden_ = Load(network.value_hidden);
    value_output_ = Load(network.value_output);
    policy_convolution_ = Load(network.policy_convolution);
    policy_output_ = Load(network.policy_output);
    has_own_head_ = network.own_hidden.outputs > 0;
    if (!has_own_head_) return;
    own_hidden_ = Load(network.own_hidden);
    own_value_ = Load(network.own_value);
    own_policy_ = Load(network.own_policy);
  }

  // planes: [positions, 23, 11, 11] on any device. Returns [positions, 7] on the CPU as fp32:
  // policy probabilities, then value.
  [[nodiscard]] torch::Tensor Forward(const torch::Tensor& planes) const {
    const torch::Tensor input = ToInput(planes);
    torch::Tensor x = Activate(Run(stem_, input));
    for (const BlockLayers& block : blocks_) x = Run(block, x);
    torch::Tensor policy = Run(policy_output_, Activate(Run(policy_convolution_, x)));
    torch::Tensor hidden = Run(value_hidden_, Activate(Run(value_convolution_, x)));
    if (has_own_head_) {
      const torch::Tensor own = OwnFeatures(x, input);
      hidden += Run(own_value_, own);
      policy += Run(own_policy_, own);
    }
    const torch::Tensor value = Run(value_output_, Activate(hidden));
    return torch::cat({policy.to(torch::kFloat32).softmax(1), value.to(torch::kFloat32).tanh()}, 1)
        .to(torch::kCPU);
  }

 private:
  struct Convolution {
    torch::Tensor weights;
    torch::Tensor bias;
    int stride = 1;
    int padding = 0;
    int groups = 1;
  };
  struct Linear {
    torch::Tensor weights;
    torch::Tensor bias;  // undefined: 0
  };
  struct BlockLayers {
    std::vector<Convolution> convolutions;
    bool skip;
    bool final_activation;
  };

  [[nodiscard]] torch::Tensor Tensor(const std::vector<float>& values,
                                     torch::IntArrayRef shape) const {
    return torch::tensor(values, torch::kFloat32).reshape(shape).to(options_);
  }
  [[nodiscard]] Convolution Load(const FoldedConvolution& layer) const {
    const torch::Tensor weights = Tensor(
        layer.weights, {layer.outputs, layer.inputs / layer.groups, layer.kernel, layer.kernel});
    return {weights.contiguous(torch::MemoryFormat::ChannelsLast),
            Tensor(layer.bias, {layer.outputs}), layer.stride, layer.kernel / 2, layer.groups};
  }
  [[nodiscard]] Linear Load(const LinearLayer& layer) const {
    Linear linear{Tensor(layer.weights, {layer.outputs, layer.inputs}), {}};
    if (!layer.bias.empty()) linear.bias = Tensor(layer.bias, {layer.outputs});
    return linear;
  }

  [[nodiscard]] torch::Tensor ToInput(const torch::Tensor& planes) const {
    return planes.to(options_).contiguous(torch::MemoryFormat::ChannelsLast);
  }
  [[nodiscard]] torch::Tensor Activate(torch::Tensor x) const {
    return torch::leaky_relu_(x, leaky_slope_);
  }
  [[nodiscard]] static torch::Tensor Run(const Convolution& layer, const torch::Tensor& x) {
    return torch::conv2d(x, layer.weights, layer.bias, layer.stride, layer.padding,
                         /*dilation=*/1, layer.groups);
  }
  [[nodiscard]] static torch::Tensor Run(const Linear& layer, const torch::Tensor& x) {
    return torch::linear(x.flatten(1), layer.weights, layer.bias);
  }
  [[nodiscard]] torch::Tensor Run(const BlockLayers& block, const torch::Tensor& input) const {
    torch::Tensor x = input;
    for (std::size_t i = 0; i < block.convolutions.size(); ++i) {
      x = Run(block.convolutions[i], x);
      if (i + 1 < block.convolutions.size()) x = Activate(x);
    }
    if (block.skip) x += input;
    return block.final_activation ? Activate(x) : x;
  }

  // As NetworkImpl::OwnFeatures.
  [[nodiscard]] torch::Tensor OwnFeatures(const torch::Tensor& tower,
                                          const torch::Tensor& input) const {
    const torch::Tensor marked = input.slice(/*dim=*/1, kOwnCellPlane, kOwnCellPlane + 1);
    return Activate(Run(own_hidden_, (tower * marked).sum({2, 3}))) * marked.sum({2, 3});
  }

  torch::TensorOptions options_;
  double leaky_slope_;
  Convolution stem_;
  std::vector<BlockLayers> blocks_;
  Convolution value_convolution_;
  Linear value_hidden_;
  Linear value_output_;
  Convolution policy_convolution_;
  Linear policy_output_;
  bool has_own_head_ = false;
  Linear own_hidden_;
  Linear own_value_;
  Linear own_policy_;
};

class TorchEvaluator final : public Evaluator {
 public:
  TorchEvaluator(const WeightsSnapshot& snapshot, const TorchEvaluatorSettings& settings)
      : settings_(settings),
        slice_(settings.device == TorchDevice::kCpu ? kCpuSlice : kCudaSlice),
        network_(Fold(snapshot), torch::TensorOptions()
                                     .dtype(ScalarTypeOf(settings.precision))
                                     .device(DeviceOf(settings))) {}

  void Evaluate(const GameSettings& settings, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    CHECK(positions.size() == evaluations.size());
    const c10::InferenceMode inference;
    at::set_num_threads(1);
    for (std::size_t first = 0; first < positions.size(); first += slice_) {
      const std::size_t count = std::min(slice_, positions.size() - first);
      EvaluateSlice(settings, positions.subspan(first, count), evaluations.subspan(first, count));
    }
  }

  [[nodiscard]] std::string name() const override {
    return StrCat("torch ", settings_.device == TorchDevice::kCpu ? "cpu" : "cuda", " ",
                  NameOf(settings_.precision));
  }

 private:
  void EvaluateSlice(const GameSettings& settings, std::span<const Position> positions,
                     std::span<Evaluation> evaluations) {
    const auto count = static_cast<std::int64_t>(positions.size());
    const torch::Tensor planes = PlanesBuffer(count);
    float* next = planes.data_ptr<float>();
    for (const Position& position : positions) {
      EncodePlanes(settings, position, std::span<float, kPlanesSize>(next, kPlanesSize));
      next += kPlanesSize;
    }
    const torch::Tensor answers = network_.Forward(planes).contiguous();
    const float* answer = answers.data_ptr<float>();
    for (Evaluation& evaluation : evaluations) {
      std::copy_n(answer, kActionCount, evaluation.policy.begin());
      evaluation.value = answer[kActionCount];
      answer += kActionCount + 1;
    }
  }

  // [count, 23, 11, 11] on the CPU; the memory is kept between calls (pinned for CUDA).
  torch::Tensor PlanesBuffer(std::int64_t count) {
    if (!buffer_.defined() || buffer_.size(0) < count) {
      buffer_ = torch::empty({count, kPlaneCount, kBoardSize, kBoardSize},
                             torch::TensorOptions()
                                 .dtype(torch::kFloat32)
                                 .pinned_memory(settings_.device == TorchDevice::kCuda));
    }
    return buffer_.narrow(0, 0, count);
  }

  TorchEvaluatorSettings settings_;
  std::size_t slice_;
  InferenceNetwork network_;
  torch::Tensor buffer_;
};

}  // namespace

bool IsCudaAvailable() { return torch::cuda::is_available(); }

std::unique_ptr<Evaluator> MakeTorchEvaluator(const Snapshot& snapshot,
                                              const TorchEvaluatorSettings& settings) {
  Validate(settings);
  Validate(*snapshot);
  InitialiseTorch(/*threads=*/1);
  return std::make_unique<TorchEvaluator>(*snapshot, settings);
}

}  // namespace powderkeg

#include "learner/train/training_pass.h"

#include <ATen/Parallel.h>
#include <ATen/autocast_mode.h>

#include <string>
#include <utility>

#include "common/model/planes.h"

namespace powderkeg {
namespace {

// Switches autocast to bf16 while it lives.
class Autocast {
 public:
  Autocast(torch::Device device, Precision precision)
      : device_(device), on_(precision == Precision::kBf16) {
    if (on_) Switch(true);
  }
  ~Autocast() {
    if (!on_) return;
    Switch(false);
    at::autocast::clear_cache();
  }
  Autocast(const Autocast&) = delete;
  Autocast& operator=(const Autocast&) = delete;

 private:
  void Switch(bool on) const {
#if TORCH_VERSION_MAJOR > 2 || (TORCH_VERSION_MAJOR == 2 && TORCH_VERSION_MINOR >= 4)
    at::autocast::set_autocast_dtype(device_.type(), torch::kBFloat16);
    at::autocast::set_autocast_enabled(device_.type(), on);
#else
    if (device_.is_cuda()) {
      at::autocast::set_autocast_gpu_dtype(torch::kBFloat16);
      at::autocast::set_enabled(on);
    } else {
      at::autocast::set_autocast_cpu_dtype(torch::kBFloat16);
      at::autocast::set_cpu_enabled(on);
    }
#endif
  }

  torch::Device device_;
  bool on_;
};

void ForEachTorchThread(int count, const std::function<void(int)>& work) {
  at::parallel_for(0, count, /*grain_size=*/1, [&](std::int64_t first, std::int64_t end) {
    for (std::int64_t i = first; i < end; ++i) work(static_cast<int>(i));
  });
}

float* GradientOf(torch::Tensor& parameter) {
  if (!parameter.grad().defined()) parameter.mutable_grad() = torch::zeros_like(parameter);
  return parameter.mutable_grad().data_ptr<float>();
}

// All convolutions with their norms, in the order of ArraysOf.
std::vector<ConvolutionParameters> ConvolutionsOf(Network& network) {
  const auto parameters = network->named_parameters();
  const auto buffers = network->named_buffers();
  std::vector<ConvolutionParameters> convolutions;
  for (const ArrayShape& array : ArraysOf(network->description())) {
    if (array.shape.size() != 4) continue;
    const std::size_t conv = array.name.rfind("conv");
    std::string norm = array.name.substr(0, array.name.rfind('.'));
    norm.replace(conv, 4, "bn");
    torch::Tensor weights = parameters[array.name];
    torch::Tensor norm_weights = parameters[norm + ".weight"];
    torch::Tensor norm_biases = parameters[norm + ".bias"];
    torch::Tensor mean = buffers[norm + ".running_mean"];
    torch::Tensor variance = buffers[norm + ".running_var"];
    convolutions.push_back({.weights = weights.data_ptr<float>(),
                            .norm_weights = norm_weights.data_ptr<float>(),
                            .norm_biases = norm_biases.data_ptr<float>(),
                            .running_mean = mean.data_ptr<float>(),
                            .running_variance = variance.data_ptr<float>(),
                            .weights_gradient = GradientOf(weights),
                            .norm_weights_gradient = GradientOf(norm_weights),
                            .norm_biases_gradient = GradientOf(norm_biases)});
  }
  return convolutions;
}

// Convolutions of LibTorch are fastest with their channels last.
void PutChannelsLast(Network& network) {
  for (torch::Tensor& parameter : network->parameters()) {
    if (parameter.dim() != 4) continue;
    parameter.set_data(parameter.data().contiguous(torch::MemoryFormat::ChannelsLast));
  }
}

}  // namespace

TrainingPass::TrainingPass(Network network, torch::Device device, Precision precision, int threads)
    : network_(std::move(network)), device_(device), precision_(precision) {
  const NetworkDescription& description = network_->description();
  if (device.is_cpu() && precision == Precision::kBf16 && FusedTower::CanRun(description)) {
    tower_ = std::make_unique<FusedTower>(description, threads, ForEachTorchThread);
    convolutions_ = ConvolutionsOf(network_);
  } else {
    PutChannelsLast(network_);
  }
}

NetworkOutput TrainingPass::Forward(std::vector<float>& planes, std::int64_t positions) {
  const torch::Tensor input =
      torch::from_blob(planes.data(), {positions, kPlaneCount, kBoardSize, kBoardSize});
  if (tower_ != nullptr && network_->is_training()) return ForwardFused(input);
  const Autocast autocast(device_, precision_);
  return network_->forward(input.to(device_).contiguous(torch::MemoryFormat::ChannelsLast));
}

NetworkOutput TrainingPass::ForwardFused(const torch::Tensor& planes) {
  const NetworkDescription& description = network_->description();
  const std::int64_t positions = planes.size(0);
  const std::int64_t cells = TowerBoardSize(description) * TowerBoardSize(description);
  const HeadArrays<float> arrays =
      tower_->Forward(static_cast<int>(positions), planes.data_ptr<float>(), convolutions_);
  const auto leaf = [](float* values, torch::IntArrayRef shape) {
    return torch::from_blob(values, shape).requires_grad_();
  };
  head_inputs_ = {.value = leaf(arrays.value, {positions, description.value_channels * cells}),
                  .policy = leaf(arrays.policy, {positions, description.policy_channels * cells}),
                  .marked = {},
                  .present = {}};
  if (arrays.marked != nullptr) {
    head_inputs_.marked = leaf(arrays.marked, {positions, kAgentCount, arrays.channels});
    head_inputs_.present =
        planes.slice(/*dim=*/1, kOwnCellPlane, kOwnCellPlane + kAgentCount).flatten(2).sum(2);
  }
  return network_->Heads(head_inputs_);
}

void TrainingPass::Backward(const torch::Tensor& loss) {
  loss.backward();
  if (!head_inputs_.value.defined()) return;
  const auto gradient = [](const torch::Tensor& input) -> const float* {
    return input.defined() ? input.grad().data_ptr<float>() : nullptr;
  };
  tower_->Backward({gradient(head_inputs_.value), gradient(head_inputs_.policy),
                    gradient(head_inputs_.marked), 0},
                   convolutions_);
  head_inputs_ = {};
}

}  // namespace powderkeg

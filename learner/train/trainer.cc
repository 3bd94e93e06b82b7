#include "learner/train/trainer.h"

#include <ATen/autocast_mode.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <type_traits>
#include <utility>

#include "common/base/check.h"
#include "common/base/log.h"
#include "common/model/planes.h"
#include "common/torch/snapshot_conversion.h"
#include "common/torch/torch_evaluator.h"
#include "common/torch/torch_headers.h"
#include "common/torch/torch_network.h"
#include "common/torch/torch_runtime.h"
#include "learner/train/batch.h"
#include "learner/train/schedule.h"

namespace powderkeg {
namespace {

using torch::optim::AdamW;
using torch::optim::AdamWOptions;
using torch::optim::AdamWParamState;
using Clock = std::chrono::steady_clock;

// Samples that are computed with at once: these bound memory and the time to a stop.
constexpr std::size_t kSlice = 1024;

// A loss so many times that of guessing is worth a word.
constexpr double kFarAboveGuessing = 2;

// Of an action that cannot be taken.
constexpr double kImpossibleLogit = -1e9;

constexpr const char* kFirstMoment = ".exp_avg";
constexpr const char* kSecondMoment = ".exp_avg_sq";

// ---- Device and precision -----------------------------------------------------------------------

torch::Device DeviceFor(const std::string& name) {
  const bool cuda = IsCudaAvailable();
  if (name == "cpu" || (name == "auto" && !cuda)) return torch::kCPU;
  if (name != "cuda" && name != "auto") {
    throw Error(StrCat("training.device is ", name, ", expected auto, cpu or cuda"));
  }
  if (!cuda) throw Error("training.device is cuda, but LibTorch finds no CUDA device");
  return torch::kCUDA;
}

Precision PrecisionFor(const std::optional<Precision>& wanted, torch::Device device) {
  if (wanted == Precision::kFp16) throw Error("training in fp16 is not offered, use bf16 or fp32");
  if (wanted) return *wanted;
  return device.is_cuda() || __builtin_cpu_supports("avx512bf16") ? Precision::kBf16
                                                                  : Precision::kFp32;
}

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

// ---- Optimizer state ----------------------------------------------------------------------------

// The optimizer's name for a parameter: text in LibTorch 1, a pointer in LibTorch 2.
template <typename States>
auto KeyOf(const States&, const torch::Tensor& parameter) {
  if constexpr (std::is_same_v<typename States::key_type, std::string>) {
    return c10::guts::to_string(parameter.unsafeGetTensorImpl());
  } else {
    return static_cast<void*>(parameter.unsafeGetTensorImpl());
  }
}

NamedArray ToArray(std::string name, const torch::Tensor& tensor) {
  const torch::Tensor values = tensor.detach().to(torch::kCPU, torch::kFloat32).contiguous();
  const float* const first = values.data_ptr<float>();
  return {std::move(name), tensor.sizes().vec(), {first, first + values.numel()}};
}

// The array `name` in the memory format and on the device of `like`. Throws Error.
torch::Tensor FromArray(const std::vector<NamedArray>& arrays, const std::string& name,
                        const torch::Tensor& like) {
  const auto found = std::ranges::find(arrays, name, &NamedArray::name);
  if (found == arrays.end()) throw Error(StrCat("optimizer state: ", name, " is missing"));
  if (like.sizes() != torch::IntArrayRef(found->shape)) {
    throw Error(StrCat("optimizer state: ", name, " has another shape than its parameter"));
  }
  const torch::Tensor values =
      torch::from_blob(const_cast<float*>(found->values.data()), found->shape, torch::kFloat32);
  return torch::empty_like(like, torch::TensorOptions().requires_grad(false)).copy_(values);
}

// ---- One training step --------------------------------------------------------------------------

TargetSettings TargetsOf(const TrainingConfig& training) {
  return {.argmax_weight = training.target_argmax_weight,
          .outcome_values = {.draw = training.draw_value.value_or(0),
                             .late_win = training.late_win_value.value_or(1)},
          .search_value_weight = training.target_search_value_weight};
}

// Sums over samples, kept on the device: reading them waits for it.
struct Losses {
  torch::Tensor policy;
  torch::Tensor value;
  torch::Tensor agreements;  // of samples that have a policy target
  torch::Tensor policies;    // such samples
  torch::Tensor others;
  torch::Tensor foretold;      // of the others in view, those whose action was the likeliest
  torch::Tensor others_count;  // the others in view
  std::uint64_t samples = 0;

  explicit Losses(torch::Device device) {
    const auto options = torch::TensorOptions().dtype(torch::kFloat64).device(device);
    policy = torch::zeros({}, options);
    value = torch::zeros({}, options);
    agreements = torch::zeros({}, options);
    policies = torch::zeros({}, options);
    others = torch::zeros({}, options);
    foretold = torch::zeros({}, options);
    others_count = torch::zeros({}, options);
  }
};

// The next samples of endless passes over the window.
class SampleStream {
 public:
  SampleStream(const ReplayWindow& window, Rng& rng) : window_(window), rng_(rng) {}

  void Next(std::span<const Sample*> samples) {
    for (const Sample*& sample : samples) {
      if (next_ == order_.size()) {
        order_ = window_.ShuffledOrder(rng_);
        next_ = 0;
      }
      sample = &window_[order_[next_++]];
    }
  }

 private:
  const ReplayWindow& window_;
  Rng& rng_;
  std::vector<std::uint32_t> order_;
  std::size_t next_ = 0;
};

}  // namespace

struct Trainer::Implementation {
  TrainerSettings settings;
  TargetSettings targets;
  torch::Device device;
  Precision precision;
  Network network;
  AdamW optimizer;
  std::uint64_t steps;
  std::uint64_t samples_seen;
  TrainingBatch batch;

  Implementation(const TrainerSettings& trainer_settings, const TrainerState& state)
      : settings(trainer_settings),
        targets(TargetsOf(settings.training)),
        device(DeviceFor(settings.training.device)),
        precision(PrecisionFor(settings.precision, device)),
        network(MakeOnDevice(state.weights, device)),
        optimizer(network->parameters(), AdamWOptions(settings.training.learning_rate)
                                             .weight_decay(settings.training.weight_decay)),
        steps(state.optimizer_steps),
        samples_seen(state.samples_seen) {
    if (!state.optimizer.empty()) RestoreOptimizer(state);
  }

  static Network MakeOnDevice(const WeightsSnapshot& weights, torch::Device device) {
    Network network = MakeNetwork(weights);
    network->to(device);
    for (torch::Tensor& parameter : network->parameters()) {
      if (parameter.dim() == 4) {
        parameter.set_data(parameter.data().contiguous(torch::MemoryFormat::ChannelsLast));
      }
    }
    return network;
  }

  void RestoreOptimizer(const TrainerState& state) {
    for (const auto& parameter : network->named_parameters()) {
      auto moments = std::make_unique<AdamWParamState>();
      moments->step(static_cast<std::int64_t>(steps));
      moments->exp_avg(FromArray(state.optimizer, parameter.key() + kFirstMoment, *parameter));
      moments->exp_avg_sq(FromArray(state.optimizer, parameter.key() + kSecondMoment, *parameter));
      optimizer.state()[KeyOf(optimizer.state(), *parameter)] = std::move(moments);
    }
  }

  [[nodiscard]] std::vector<NamedArray> OptimizerArrays() {
    std::vector<NamedArray> arrays;
    for (const auto& parameter : network->named_parameters()) {
      const auto found = optimizer.state().find(KeyOf(optimizer.state(), *parameter));
      if (found == optimizer.state().end()) return {};  // no step yet
      const auto& moments = static_cast<const AdamWParamState&>(*found->second);
      arrays.push_back(ToArray(parameter.key() + kFirstMoment, moments.exp_avg()));
      arrays.push_back(ToArray(parameter.key() + kSecondMoment, moments.exp_avg_sq()));
    }
    return arrays;
  }

  [[nodiscard]] torch::Tensor OnDevice(std::vector<float>& values, torch::IntArrayRef shape) const {
    return torch::from_blob(values.data(), shape, torch::kFloat32).to(device);
  }

  // Of the slice in `batch`, the sum over its samples; its parts are added to `losses`.
  torch::Tensor LossOf(Losses& losses) {
    const auto size = static_cast<std::int64_t>(batch.size);
    const torch::Tensor planes = OnDevice(batch.planes, {size, kPlaneCount, kBoardSize, kBoardSize})
                                     .contiguous(torch::MemoryFormat::ChannelsLast);
    const torch::Tensor policies = OnDevice(batch.policies, {size, kActionCount});
    const torch::Tensor values = OnDevice(batch.values, {size});
    NetworkOutput output;
    {
      const Autocast autocast(device, precision);
      output = network->forward(planes);
    }
    const torch::Tensor logits = output.policy_logits.to(torch::kFloat32);
    const torch::Tensor policy_loss = -(policies * logits.log_softmax(1)).sum();
    const torch::Tensor value_loss = (values - output.value.to(torch::kFloat32)).square().sum();
    losses.policy += policy_loss.detach();
    losses.value += value_loss.detach();
    const torch::Tensor has_policy = policies.sum(1) > 0;
    losses.agreements += (logits.argmax(1).eq(policies.argmax(1)) & has_policy).sum();
    losses.policies += has_policy.sum();
    losses.samples += batch.size;
    const double alpha = settings.training.value_weight;
    const torch::Tensor loss = alpha * value_loss + (1 - alpha) * policy_loss;
    if (!output.others_logits.defined()) return loss;
    return loss + settings.training.others_weight * OthersLossOf(output.others_logits, losses);
  }

  // Of all that are in view, the sum; what their positions do not allow has no weight.
  torch::Tensor OthersLossOf(const torch::Tensor& all_logits, Losses& losses) {
    const torch::IntArrayRef shape = all_logits.sizes();
    const torch::Tensor did = OnDevice(batch.others, shape);
    const torch::Tensor legal = OnDevice(batch.others_legal, shape);
    const torch::Tensor logits =
        all_logits.to(torch::kFloat32).masked_fill(legal == 0, kImpossibleLogit);
    const torch::Tensor loss = -(did * logits.log_softmax(2)).sum();
    const torch::Tensor in_view = did.sum(2) > 0;
    losses.others += loss.detach();
    losses.foretold += (logits.argmax(2).eq(did.argmax(2)) & in_view).sum();
    losses.others_count += in_view.sum();
    return loss;
  }

  // One step of the optimizer, on slices of the batch. False: stopped, without a step.
  bool Step(double learning_rate, SampleStream& stream, Rng& rng, Losses& losses,
            const std::stop_token& stop, const std::function<void()>& slice_done) {
    const auto batch_size = static_cast<std::size_t>(settings.training.batch_size);
    std::vector<const Sample*> slice;
    optimizer.zero_grad();
    for (torch::optim::OptimizerParamGroup& group : optimizer.param_groups()) {
      static_cast<AdamWOptions&>(group.options()).lr(learning_rate);
    }
    for (std::size_t left = batch_size; left > 0; left -= slice.size()) {
      if (stop.stop_requested()) return false;
      slice.resize(std::min(left, kSlice));
      stream.Next(slice);
      BuildBatch(settings.game, targets, slice, rng, batch);
      (LossOf(losses) / settings.training.batch_size).backward();
      slice_done();
    }
    optimizer.step();
    ++steps;
    samples_seen += batch_size;
    return true;
  }

  [[nodiscard]] TrainingResult ResultOf(const Losses& losses, Clock::time_point start) const {
    TrainingResult result;
    result.samples = losses.samples;
    const double count = std::max(1.0, static_cast<double>(losses.samples));
    const double policies = std::max(1.0, losses.policies.item<double>());
    result.policy_loss = losses.policy.item<double>() / policies;
    result.value_loss = losses.value.item<double>() / count;
    result.policy_accuracy = losses.agreements.item<double>() / policies;
    const double others = std::max(1.0, losses.others_count.item<double>());
    result.others_loss = losses.others.item<double>() / others;
    result.others_accuracy = losses.foretold.item<double>() / others;
    const double alpha = settings.training.value_weight;
    const double policy_share = policies / count;
    result.total_loss = alpha * result.value_loss +
                        (1 - alpha) * policy_share * result.policy_loss +
                        settings.training.others_weight * losses.others.item<double>() / count;
    if (!std::isfinite(result.total_loss)) {
      throw Error(StrCat("training diverged: the loss is ", result.total_loss,
                         "; try a smaller training.learning_rate than ",
                         settings.training.learning_rate));
    }
    const std::chrono::duration<double> seconds = Clock::now() - start;
    result.samples_per_s = static_cast<double>(losses.samples) / seconds.count();
    return result;
  }

  void WarnOfLoss(double loss) const {
    const double alpha = settings.training.value_weight;
    const double guess = std::log(double{kActionCount});
    const double guessing =
        alpha + (1 - alpha + settings.training.others_weight * (kAgentCount - 1)) * guess;
    if (loss <= kFarAboveGuessing * guessing) return;
    log::Warn("the loss is far above that of guessing; try a smaller training.learning_rate",
              "loss", loss, "guessing", guessing);
  }
};

Trainer::Trainer(const TrainerSettings& settings, const TrainerState& state) {
  InitialiseTorch(settings.training.threads);
  implementation_ = std::make_unique<Implementation>(settings, state);
}

Trainer::~Trainer() = default;

TrainingResult Trainer::Train(const ReplayWindow& window, int iteration, Rng rng,
                              const std::stop_token& stop,
                              const std::function<void(const TrainingProgress&)>& progress) {
  CHECK(window.size() > 0);
  Implementation& trainer = *implementation_;
  const TrainingConfig& training = trainer.settings.training;
  InitialiseTorch(training.threads);
  const auto batch_size = static_cast<std::size_t>(training.batch_size);
  const double wanted = training.epochs * static_cast<double>(window.size());
  const auto batches = static_cast<std::uint64_t>(
      std::max(1.0, std::round(wanted / static_cast<double>(batch_size))));
  SampleStream stream(window, rng);
  Losses losses(trainer.device);
  const Clock::time_point start = Clock::now();
  std::uint64_t done = 0;
  trainer.network->train();
  const auto slice_done = [&] {
    if (progress) progress({losses.samples, batches * batch_size});
  };
  const auto rate = [&] {
    const double part = static_cast<double>(done) / static_cast<double>(batches);
    return LearningRateAfter(training, iteration - 1 + part);
  };
  while (done < batches && trainer.Step(rate(), stream, rng, losses, stop, slice_done)) ++done;
  TrainingResult result = trainer.ResultOf(losses, start);
  trainer.WarnOfLoss(result.total_loss);
  result.finished = done == batches;
  return result;
}

TrainingResult Trainer::Measure(std::span<const Sample> samples) {
  Implementation& trainer = *implementation_;
  const torch::NoGradGuard no_gradients;
  trainer.network->eval();
  Losses losses(trainer.device);
  Rng rng(/*seed=*/0);
  const Clock::time_point start = Clock::now();
  for (std::size_t first = 0; first < samples.size(); first += kSlice) {
    std::vector<const Sample*> slice;
    for (const Sample& sample : samples.subspan(first, std::min(kSlice, samples.size() - first))) {
      slice.push_back(&sample);
    }
    BuildBatch(trainer.settings.game, trainer.targets, slice, rng, trainer.batch);
    (void)trainer.LossOf(losses);
  }
  TrainingResult result = trainer.ResultOf(losses, start);
  result.finished = true;
  return result;
}

TrainerState Trainer::state(std::uint32_t version) const {
  return {.weights = ToSnapshot(implementation_->network, version),
          .optimizer = implementation_->OptimizerArrays(),
          .optimizer_steps = implementation_->steps,
          .samples_seen = implementation_->samples_seen};
}

std::string Trainer::description() const {
  return StrCat(implementation_->device.is_cuda() ? "cuda" : "cpu", " ",
                NameOf(implementation_->precision), ", ",
                implementation_->settings.training.threads, " threads");
}

Snapshot MakePublishedSnapshot(const TrainerState& state, const ReplayWindow& window,
                               std::size_t positions) {
  std::vector<State> states;
  std::vector<AgentId> viewers;
  const std::size_t count = std::min(positions, window.size());
  for (std::size_t i = 0; i < count; ++i) {
    const Sample& sample = window[i * window.size() / count];
    states.push_back(sample.state);
    viewers.push_back(sample.viewer);
  }
  const auto evaluator = MakeTorchEvaluator(std::make_shared<WeightsSnapshot>(state.weights),
                                            TorchEvaluatorSettings{});
  auto snapshot = std::make_shared<WeightsSnapshot>(state.weights);
  snapshot->canary = MakeCanary(std::move(states), std::move(viewers), *evaluator);
  return snapshot;
}

}  // namespace powderkeg

#include "learner/train/trainer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "common/base/check.h"
#include "common/base/log.h"
#include "common/torch/snapshot_conversion.h"
#include "common/torch/torch_evaluator.h"
#include "common/torch/torch_headers.h"
#include "common/torch/torch_network.h"
#include "common/torch/torch_runtime.h"
#include "learner/train/adamw.h"
#include "learner/train/batch.h"
#include "learner/train/schedule.h"
#include "learner/train/training_pass.h"

namespace powderkeg {
namespace {

using Clock = std::chrono::steady_clock;

// Samples that are computed with at once: these bound memory and the time to a stop.
constexpr std::size_t kSlice = 1024;

// A loss so many times that of guessing is worth a word.
constexpr double kFarAboveGuessing = 2;

// Of an action that cannot be taken.
constexpr double kImpossibleLogit = -1e9;

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
  torch::Tensor entropy;  // of the policy targets
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
    entropy = torch::zeros({}, options);
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

std::size_t SamplesOfEpoch(const TrainingConfig& training, const ReplayWindow& window) {
  const auto usual = static_cast<std::size_t>(training.window_datasets) *
                     static_cast<std::size_t>(training.decisions_per_iteration);
  return training.continuous ? std::min(usual, window.size()) : window.size();
}

}  // namespace

struct Trainer::Implementation {
  TrainerSettings settings;
  TargetSettings targets;
  torch::Device device;
  Precision precision;
  Network network;
  TrainingPass pass;
  AdamW optimizer;
  std::uint64_t samples_seen;
  TrainingBatch batch;

  Implementation(const TrainerSettings& trainer_settings, const TrainerState& state)
      : settings(trainer_settings),
        targets(TargetsOf(settings.training)),
        device(DeviceFor(settings.training.device)),
        precision(PrecisionFor(settings.precision, device)),
        network(MakeOnDevice(state.weights, device)),
        pass(network, device, precision, settings.training.threads),
        optimizer(*network, settings.training.weight_decay, state.optimizer_steps),
        samples_seen(state.samples_seen) {
    if (!state.optimizer.empty()) optimizer.Restore(state.optimizer);
  }

  static Network MakeOnDevice(const WeightsSnapshot& weights, torch::Device device) {
    Network network = MakeNetwork(weights);
    network->to(device);
    return network;
  }

  [[nodiscard]] torch::Tensor OnDevice(std::vector<float>& values, torch::IntArrayRef shape) const {
    return torch::from_blob(values.data(), shape, torch::kFloat32).to(device);
  }

  // Of the slice in `batch`, the sum over its samples; its parts are added to `losses`.
  torch::Tensor LossOf(Losses& losses) {
    const auto size = static_cast<std::int64_t>(batch.size);
    const torch::Tensor policies = OnDevice(batch.policies, {size, kActionCount});
    const torch::Tensor values = OnDevice(batch.values, {size});
    const NetworkOutput output = pass.Forward(batch.planes, size);
    const torch::Tensor logits = output.policy_logits.to(torch::kFloat32);
    const torch::Tensor policy_loss = -(policies * logits.log_softmax(1)).sum();
    const torch::Tensor value_loss = (values - output.value.to(torch::kFloat32)).square().sum();
    losses.policy += policy_loss.detach();
    losses.entropy -= torch::xlogy(policies, policies).sum();
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
    optimizer.ZeroGradients();
    for (std::size_t left = batch_size; left > 0; left -= slice.size()) {
      if (stop.stop_requested()) return false;
      slice.resize(std::min(left, kSlice));
      stream.Next(slice);
      BuildBatch(settings.game, targets, slice, rng, batch);
      pass.Backward(LossOf(losses) / settings.training.batch_size);
      slice_done();
    }
    optimizer.Step(learning_rate);
    samples_seen += batch_size;
    return true;
  }

  [[nodiscard]] TrainingResult ResultOf(const Losses& losses, Clock::time_point start) const {
    TrainingResult result;
    result.samples = losses.samples;
    const double count = std::max(1.0, static_cast<double>(losses.samples));
    const double policies = std::max(1.0, losses.policies.item<double>());
    result.policy_loss = losses.policy.item<double>() / policies;
    result.target_entropy = losses.entropy.item<double>() / policies;
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
  const double wanted = training.epochs * static_cast<double>(SamplesOfEpoch(training, window));
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
          .optimizer = implementation_->optimizer.Arrays(),
          .optimizer_steps = implementation_->optimizer.steps(),
          .samples_seen = implementation_->samples_seen};
}

std::string Trainer::description() const {
  return StrCat(implementation_->device.is_cuda() ? "cuda" : "cpu", " ",
                NameOf(implementation_->precision),
                implementation_->pass.fused() ? " by own kernels, " : " by LibTorch's, ",
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

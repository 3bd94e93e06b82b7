#pragma once

// Trains the network on a window of samples. No Torch type in this header.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "common/config/run_config.h"
#include "common/model/precision.h"
#include "common/model/weights_snapshot.h"
#include "learner/replay/window.h"
#include "learner/train/trainer_state.h"

namespace powderkeg {

struct TrainerSettings {
  TrainingConfig training;
  GameSettings game;  // of every sample
  // Of activations and products (autocast; weights and optimizer stay fp32). None: bf16 where the
  // device computes it natively, else fp32.
  std::optional<Precision> precision;
};

// Means over the samples trained on.
struct TrainingResult {
  // alpha * value_loss + (1 - alpha) * policy_loss, which is 0 for samples without a policy target,
  // + others_weight * others_loss for each of the others that is foretold.
  double total_loss = 0;
  double policy_loss = 0;  // cross entropy over all six actions; of samples with a policy target
  double value_loss = 0;   // (z' - v)^2
  double policy_accuracy = 0;  // how often the best action is the target's, where there is one
  // Of the others in view, each by itself; 0 where the network foretells nobody.
  double others_loss = 0;      // cross entropy over what the position allows
  double others_accuracy = 0;  // how often the likeliest action was taken
  std::uint64_t samples = 0;
  double samples_per_s = 0;
  bool finished = false;  // false: stopped early
};

struct TrainingProgress {
  std::uint64_t samples_done = 0;
  std::uint64_t samples = 0;
};

// Owns network and optimizer (AdamW). One thread; uses the threads of
// LibTorch that the settings say. On the CPU in fp32, equal calls give equal weights bit for bit.
class Trainer {
 public:
  // Throws Error on an unknown or absent device or invalid weights.
  Trainer(const TrainerSettings& settings, const TrainerState& state);
  ~Trainer();
  Trainer(const Trainer&) = delete;
  Trainer& operator=(const Trainer&) = delete;

  // Trains iteration k (from 1) for settings.epochs passes over the window, each in a new random
  // order, in whole batches (at least one), at the rates of LearningRateAfter. Large batches are
  // computed in slices (normalised slice by slice), and `progress` is called, and a stop noticed,
  // after each: the batch then changes no weight. Requires a window that is not empty. Throws Error
  // if the loss is not finite, and warns if it is far above that of guessing.
  TrainingResult Train(const ReplayWindow& window, int iteration, Rng rng,
                       const std::stop_token& stop,
                       const std::function<void(const TrainingProgress&)>& progress);

  // The losses of samples that are not trained on, each turned by one symmetry.
  [[nodiscard]] TrainingResult Measure(std::span<const Sample> samples);

  // The state with the weights as `version`; waits for the device.
  [[nodiscard]] TrainerState state(std::uint32_t version) const;

  // For logs: "cpu bf16 by own kernels, 2 threads".
  [[nodiscard]] std::string description() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

// The weights of a state with the answers for up to `positions` positions of the window, evenly
// spaced, for actors to check what they loaded. The positions are asked without fog.
[[nodiscard]] Snapshot MakePublishedSnapshot(const TrainerState& state, const ReplayWindow& window,
                                             std::size_t positions = 8);

}  // namespace powderkeg

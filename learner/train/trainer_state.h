#pragma once

// What training carries from one iteration to the next, without Torch.

#include <cstdint>
#include <vector>

#include "common/model/weights_snapshot.h"

namespace powderkeg {

// A value. Arrays go by name, so that every version of LibTorch reads those of every other.
struct TrainerState {
  WeightsSnapshot weights;  // without a canary
  // AdamW's "<parameter>.exp_avg" and "<parameter>.exp_avg_sq"; empty before the first step.
  std::vector<NamedArray> optimizer;
  std::uint64_t optimizer_steps = 0;
  std::uint64_t samples_seen = 0;

  friend bool operator==(const TrainerState&, const TrainerState&) = default;
};

}  // namespace powderkeg

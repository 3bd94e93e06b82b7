#pragma once

// What there is to say of an iteration when it is done. learner/report shows it.

#include <array>
#include <cstdint>
#include <optional>

#include "common/base/rating.h"
#include "common/base/stats.h"
#include "common/pommerman/types.h"

namespace powderkeg {

struct IterationReport {
  int iteration = 0;  // from 1
  std::uint64_t games = 0;
  std::uint64_t decisions = 0;
  MatchScore score;                                  // of the searching agents
  MatchScore exams;                                  // of games that are not trained on, if any
  std::optional<Rating> progress;                    // League::Progress
  double mean_steps = 0;                             // per game
  std::array<double, kActionCount> action_shares{};  // of searched moves; sum 1
  double weights_lag = 0;  // mean age of the weights that games started with, in versions
  double total_loss = 0;
  double policy_loss = 0;
  double target_entropy = 0;  // of the policy's targets
  double value_loss = 0;
  double policy_accuracy = 0;  // how often the network's best action is the target's
  double others_accuracy = 0;  // how often it foretold what one of the others in view did next
  // The same of the samples that are held out, if any.
  std::uint64_t held_out_samples = 0;
  double held_out_policy_loss = 0;
  double held_out_value_loss = 0;
  double held_out_accuracy = 0;
  double held_out_others_accuracy = 0;
  double reuse_ratio = 0;    // samples trained for each decision of its games
  double samples_per_s = 0;  // trained
  double waited_s = 0;       // for games
  double trained_s = 0;

  friend bool operator==(const IterationReport&, const IterationReport&) = default;
};

}  // namespace powderkeg

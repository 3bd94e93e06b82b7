#pragma once

// The settings of a run as plain values. File format, defaults and ranges: proto/config.proto.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace powderkeg {

// Option names and values of the search, checked by the search itself (search_settings.h); the
// fields of the config message `search` that are set.
using Options = std::vector<std::pair<std::string, std::string>>;

// How games are played: what every actor of a run must use. Travels in Welcome.
struct SelfPlayConfig {
  std::string environment = "PommeFFACompetition-v0";
  std::string board_generator = "official";  // official | uniform
  std::string corners = "permuted";          // official | permuted
  // Policies of the three other seats, in the order of the seats after the searching one.
  std::array<std::string, 3> opponents = {"simple_unbiased", "simple_unbiased", "simple_unbiased"};
  std::uint64_t seed = 1;
  int games_in_flight = 32;                    // per game loop of an actor
  bool record_after_death = false;             // play on to the end after the searching agent died
  std::string weights_swap = "at_game_start";  // at_game_start | at_once
  std::string evaluator = "auto";              // auto | uniform | torch | onednn
  std::string precision = "auto";              // auto | fp32 | bf16 | fp16 | int8
  Options search;

  friend bool operator==(const SelfPlayConfig&, const SelfPlayConfig&) = default;
};

struct TrainingConfig {
  std::string network = "small";  // small | paper
  int iterations = 50;
  int decisions_per_iteration = 100'000;
  int window_datasets = 4;  // epochs run over the data sets of the last M iterations
  double epochs = 2.0;      // over the window, per iteration
  int batch_size = 256;
  double learning_rate = 1e-3;  // of the first iteration
  // Of the last iteration; between them it falls by equal factors. 0: it stays as it is.
  double final_learning_rate = 0;
  double weight_decay = 1e-4;
  double value_weight = 0.1;          // alpha: loss = alpha (z - v)^2 - (1 - alpha) pi^T log p
  double target_argmax_weight = 0.5;  // pi' = (1 - w) pi + w onehot(argmax pi)
  // z of a tie, and of a win in the last step. Not set: as in the search (TieOutcomesToSearch).
  std::optional<double> draw_value;
  std::optional<double> late_win_value;
  double target_search_value_weight = 0;  // z' = (1 - w) z + w q, q the root's value in the search
  int threads = 1;
  std::string device = "auto";  // auto | cpu | cuda
  int checkpoints_kept = 3;

  friend bool operator==(const TrainingConfig&, const TrainingConfig&) = default;
};

struct RunConfig {
  SelfPlayConfig self_play;
  TrainingConfig training;

  friend bool operator==(const RunConfig&, const RunConfig&) = default;
};

}  // namespace powderkeg

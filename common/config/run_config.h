#pragma once

// The settings of a run as plain values. Every option with its range, default and meaning:
// self_play_options.inc, search_options.inc, training_options.inc; players and line-ups: players.h.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/options.h"
#include "common/config/players.h"
#include "common/config/search_settings.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/generate.h"

namespace powderkeg {

enum class WeightsSwap : std::uint8_t { kAtGameStart, kAtOnce };
[[nodiscard]] Names NamesOf(WeightsSwap);
[[nodiscard]] Names NamesOf(BoardGenerator);
[[nodiscard]] Names NamesOf(StartCorners);

inline constexpr std::array<std::string_view, 2> kInitialisationNames = {"he", "pytorch"};
inline constexpr std::array<std::string_view, 3> kLearningRateSchedules = {"exponential", "cosine",
                                                                           "one_cycle"};
inline constexpr std::array<std::string_view, 3> kDeviceNames = {"auto", "cpu", "cuda"};

// How games are played: what every actor of a run must use. Travels in Welcome.
struct SelfPlayConfig {
#define OPTION(type, name, initial, ...) type name = initial;
#include "common/config/self_play_options.inc"
  SearchSettings search;            // of players whose agent is "search", changed by its options
  std::vector<PlayerSpec> players;  // none: as FillPlayers
  std::vector<LineupSpec> lineups;  // none: as FillPlayers

  friend bool operator==(const SelfPlayConfig&, const SelfPlayConfig&) = default;
};
[[nodiscard]] OptionTable<SelfPlayConfig> SelfPlayOptions();
// Throws Error if the environment is unknown.
[[nodiscard]] GameSettings GameOf(const SelfPlayConfig& config);

struct TrainingConfig {
#define OPTION(type, name, initial, ...) type name = initial;
#include "common/config/training_options.inc"

  friend bool operator==(const TrainingConfig&, const TrainingConfig&) = default;
};
[[nodiscard]] OptionTable<TrainingConfig> TrainingOptions();

struct RunConfig {
  SelfPlayConfig self_play;
  TrainingConfig training;

  friend bool operator==(const RunConfig&, const RunConfig&) = default;
};

}  // namespace powderkeg

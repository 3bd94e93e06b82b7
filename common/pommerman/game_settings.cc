#include "common/pommerman/game_settings.h"

#include <algorithm>

namespace powderkeg {
namespace {

struct Environment {
  std::string_view id;
  GameSettings settings;
};

constexpr std::array<int, 4> kCollapseSteps = {500, 575, 650, 725};
constexpr GameSettings kFreeForAllSettings;
constexpr GameSettings kCollapsingFreeForAll = {.collapse_steps = kCollapseSteps};
constexpr GameSettings kTeamSettings = {.mode = Mode::kTeam};
constexpr GameSettings kTeamCompetition = {
    .mode = Mode::kTeam, .blast_strength_cap = 4, .view_radius = 4};
constexpr GameSettings kCollapsingTeamCompetition = {.mode = Mode::kTeam,
                                                     .blast_strength_cap = 4,
                                                     .view_radius = 4,
                                                     .collapse_steps = kCollapseSteps};
constexpr GameSettings kRadioSettings = {
    .mode = Mode::kTeamRadio, .blast_strength_cap = 4, .view_radius = 4};
constexpr GameSettings kOneVsOneSettings = {.mode = Mode::kOneVsOne, .board_size = 8};

constexpr std::array kEnvironments = {
    Environment{"PommeFFACompetition-v0", kFreeForAllSettings},
    Environment{"PommeFFACompetitionFast-v0", kFreeForAllSettings},
    Environment{"PommeFFAFast-v0", kFreeForAllSettings},
    Environment{"PommeFFA-v1", kCollapsingFreeForAll},
    Environment{"PommeTeamCompetition-v0", kTeamCompetition},
    Environment{"PommeTeamCompetitionFast-v0", kTeamCompetition},
    Environment{"PommeTeamCompetition-v1", kCollapsingTeamCompetition},
    Environment{"PommeTeam-v0", kTeamSettings},
    Environment{"PommeTeamFast-v0", kTeamSettings},
    Environment{"PommeRadio-v2", kRadioSettings},
    Environment{"PommeRadioCompetition-v2", kRadioSettings},
    Environment{"OneVsOne-v0", kOneVsOneSettings},
};

}  // namespace

std::optional<GameSettings> GameSettingsFor(std::string_view environment_id) {
  const auto found = std::ranges::find(kEnvironments, environment_id, &Environment::id);
  if (found == kEnvironments.end()) return std::nullopt;
  return found->settings;
}

std::string KnownEnvironmentIds() {
  std::string ids;
  for (const Environment& environment : kEnvironments) {
    if (!ids.empty()) ids += ", ";
    ids += environment.id;
  }
  return ids;
}

}  // namespace powderkeg

#pragma once

// What is special at the root: exploration noise before, the choice of the move after a search.

#include <array>
#include <cstdint>
#include <span>

#include "actors/search/search_settings.h"
#include "common/base/rng.h"
#include "common/pommerman/step.h"

namespace powderkeg {

// (1 - weight) P + weight Dirichlet(alpha) over the legal actions; illegal ones stay 0.
[[nodiscard]] std::array<float, kActionCount> WithNoise(const SearchSettings& settings,
                                                        std::span<const float, kActionCount> priors,
                                                        ActionSet legal, Rng& rng);

// The move for these visits and mean values (own view, read only where visited): by default the
// most visited one, among equals the more valuable, then the lowest. Without any visit the first
// legal one of the highest prior. Settings: temperature, q_weight, q_veto.
struct RootStatistics {
  std::array<std::uint32_t, kActionCount> visits{};
  std::array<float, kActionCount> values{};
  std::array<float, kActionCount> priors{};
};
[[nodiscard]] Action ChooseMove(const SearchSettings& settings, const RootStatistics& root,
                                Rng rng);

}  // namespace powderkeg

#pragma once

// What is special at the root: exploration noise before, the choice of the move after a search.

#include <array>
#include <cstdint>
#include <span>

#include "common/base/rng.h"
#include "common/config/search_settings.h"
#include "common/pommerman/step.h"

namespace powderkeg {

// (1 - weight) P + weight Dirichlet(alpha) over the legal actions; illegal ones stay 0.
[[nodiscard]] std::array<float, kActionCount> WithNoise(const SearchSettings& settings,
                                                        std::span<const float, kActionCount> priors,
                                                        ActionSet legal, Rng& rng);

// What is known of a root; values are the searching agent's view, read only where visited.
struct RootStatistics {
  std::array<std::uint32_t, kActionCount> visits{};
  std::array<float, kActionCount> values{};
  std::array<float, kActionCount> priors{};
  ActionSet legal = (1U << kActionCount) - 1;  // what may be chosen; no other action has visits
  float evaluation = 0;                        // the evaluator's value
};

// The move for these visits and mean values: by default the most visited one, among equals the more
// valuable, then the lowest. Without any visit the first one of the highest prior. Settings:
// temperature, q_weight, q_veto.
[[nodiscard]] Action ChooseMove(const SearchSettings& settings, const RootStatistics& root,
                                Rng rng);

// Forced playouts and policy target pruning (Wu 2019, "Accelerating self-play learning in Go",
// 3.2): every visited action gets at least sqrt(k P N) of the N visits, so that noise is looked at
// closely; what they were worth by the selection rule alone is learned. k is
// settings.forced_playouts.
//
// An action that has fewer visits than that, the lowest one; kActionCount if there is none.
[[nodiscard]] std::size_t ForcedAction(double k, const RootStatistics& root);
// The visits without those that were forced: takes up to sqrt(k P N) visits off every action but
// the most visited one, as long as its score Q + exploration P / (1 + n) stays below that one's; a
// single visit that is left goes too.
[[nodiscard]] std::array<std::uint32_t, kActionCount> WithoutForced(double k, double exploration,
                                                                    const RootStatistics& root);

}  // namespace powderkeg

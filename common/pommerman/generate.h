#pragma once

// Start positions.

#include <cstdint>

#include "common/base/rng.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"

namespace powderkeg {

enum class BoardGenerator : std::uint8_t {
  kOfficial,  // the distribution of the official environment (rules, section 2)
  kUniform,   // as many walls, wood and items, on uniformly random cells, all agents connected
};

enum class StartCorners : std::uint8_t {
  kOfficial,  // agent i in corner i
  kPermuted,  // a uniformly random permutation
};

struct StartSettings {
  BoardGenerator generator = BoardGenerator::kOfficial;
  StartCorners corners = StartCorners::kOfficial;

  friend bool operator==(const StartSettings&, const StartSettings&) = default;
};

// A start position; equal arguments give equal positions on every machine. Requires the board size
// of the mode: 8 for one-against-one (agents 0 and 1 play, 2 and 3 are dead), else 11.
[[nodiscard]] State GenerateStart(const GameSettings& settings, const StartSettings& start,
                                  Rng rng);

}  // namespace powderkeg

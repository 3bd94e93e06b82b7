#pragma once

// What a record claims of searches, which nobody can play again: whether it can be true at all.

#include <cstdint>
#include <optional>
#include <string>

#include "common/record/game_record.h"
#include "common/record/game_setup.h"

namespace powderkeg {

// Why not, of a record of this run that verifies: weights that its players cannot have had, where
// `newest` is the newest version that was published, or visits that are none or more than its
// search makes.
[[nodiscard]] std::optional<std::string> WhyImplausible(const GameRecord& record,
                                                        const RunGames& games,
                                                        std::uint32_t newest);

}  // namespace powderkeg

#pragma once

// Games that were recorded elsewhere, to learn from what everybody did in them.

#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "learner/replay/lessons.h"

namespace powderkeg {

// Calls `visit` for every game of the files (common/recorded/recorded_game.h) of the rules of
// `environment`, a known official id, that teaches anything, one file after the other, with the
// tickets 0, 1, 2, ... Warns of games of other rules, which are left out. Throws Error with the
// file and what is wrong: it is truncated or no such file, a game does not follow the rules, or
// there is nothing to learn from.
void ReadDemonstrations(std::span<const std::filesystem::path> files,
                        const std::string& environment,
                        const std::function<void(Lessons&&)>& visit);

}  // namespace powderkeg

#pragma once

// Games as text in the recorded format (docs/spec/recorded_format.md).

#include <string>

#include "common/recorded/recorded_game.h"

namespace powderkeg {

// The lines of the game: header, steps, end. RecordedGameReader reads them back as the same game;
// who played and what the search found are not part of the format. Throws Error for a mode that the
// format has not (one against one).
[[nodiscard]] std::string RecordedLines(const RecordedGame& game);

}  // namespace powderkeg

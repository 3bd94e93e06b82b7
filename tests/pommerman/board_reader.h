#pragma once

// Positions from text, as tests write them down.

#include <string_view>

#include "common/pommerman/board_text.h"

namespace powderkeg {

// The inverse of ToText. Bombs lie in the order of their lines. Attribute lines are optional:
// agents on the board live with ammo 1, strength 2, no kick, agents not on it are dead; a bomb
// without a line is agent 0's, life 9, strength 2; a flame without one has life 2. Blanks around
// lines and blank lines are ignored. Throws Error on malformed text.
[[nodiscard]] State FromText(std::string_view text);

}  // namespace powderkeg

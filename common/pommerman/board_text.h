#pragma once

// Positions as text, for tests, error messages and people.

#include <string>
#include <string_view>

#include "common/pommerman/state.h"

namespace powderkeg {

// 11 lines of 11 characters as the board shows: '.' passage, '#' rigid, '+' wood, 'o' bomb,
// '*' flame, 'b' 'r' 'k' extra bomb, increase range, kick; '0'..'3' agents. What the board cannot
// show (statistics, timers, hidden items, flame lives) follows line by line:
//   step 12
//   agent 0 ammo 2 strength 3 kick words 1 7
//   agent 2 dead (9,9) ammo 1 strength 2
//   bomb (3,4) owner 0 life 5 strength 2 moving left
//   flame (1,1) life 2
//   hidden (2,2) r
[[nodiscard]] std::string ToText(const State& state);

// The inverse. Bombs lie in the order of their lines. Attribute lines are optional: agents on the
// board live with ammo 1, strength 2, no kick, agents not on it are dead; a bomb without a line is
// agent 0's, life 9, strength 2; a flame without one has life 2. Blanks around lines and blank
// lines are ignored. Throws Error on malformed text.
[[nodiscard]] State FromText(std::string_view text);

}  // namespace powderkeg

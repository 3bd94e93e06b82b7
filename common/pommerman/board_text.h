#pragma once

// Positions as text, for error messages, people and tests (which read them back).

#include <array>
#include <string>
#include <string_view>

#include "common/pommerman/state.h"

namespace powderkeg {

namespace board_text {
// What the board shows, by CellValue from kPassage to kAgent0 + 3. Fog and the dummy never occur.
inline constexpr std::string_view kCellCharacters = ".#+o*?brk?0123";
// By Item.
inline constexpr std::string_view kItemCharacters = "?brk";
inline constexpr std::array<std::string_view, 5> kDirectionNames = {"none", "up", "down", "left",
                                                                    "right"};
}  // namespace board_text

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

}  // namespace powderkeg

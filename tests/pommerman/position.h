#pragma once

// Small positions and moves for tests of the rules.

#include <initializer_list>
#include <string>
#include <string_view>

#include "common/pommerman/game_settings.h"
#include "common/pommerman/step.h"
#include "tests/pommerman/board_reader.h"

namespace powderkeg {

// The position of FromText; missing cells to the right and below are passages.
[[nodiscard]] inline State Position(std::initializer_list<std::string_view> rows,
                                    std::string_view attributes = "") {
  std::string text;
  for (const std::string_view row : rows) {
    text += row;
    text += std::string(kBoardSize - row.size(), '.') + '\n';
  }
  for (std::size_t row = rows.size(); row < kBoardSize; ++row) {
    text += std::string(kBoardSize, '.') + '\n';
  }
  return FromText(text + std::string(attributes));
}

// Actions of agents 0, 1, ...; the others stop.
[[nodiscard]] inline JointAction Actions(std::initializer_list<Action> actions) {
  JointAction joint{};
  std::size_t id = 0;
  for (const Action action : actions) joint[id++] = action;
  return joint;
}

// The position after one step.
[[nodiscard]] inline State After(State state, std::initializer_list<Action> actions,
                                 const GameSettings& settings = {}) {
  Step(settings, Actions(actions), state);
  return state;
}

}  // namespace powderkeg

#pragma once

// What the end of a game is worth to the agent that it happens to: in the search and, as z, in
// training. Both must agree, or the network is taught other values than the search compares its own
// with.

namespace powderkeg {

struct OutcomeValues {
  double draw = 0;  // of a tie
  // Of a win in the last step that a game may have; the value falls to this evenly from 1 in step
  // 0. Below 1 agents do not put off what can be won now, as waiting costs something.
  double late_win = 1;

  friend bool operator==(const OutcomeValues&, const OutcomeValues&) = default;
};

// `outcome`: +1 win, 0 tie, -1 loss; `step`, at most `max_steps`: when the game ended.
[[nodiscard]] constexpr float ValueOf(const OutcomeValues& values, int outcome, int step,
                                      int max_steps) {
  if (outcome < 0) return -1;
  if (outcome == 0) return static_cast<float>(values.draw);
  return static_cast<float>(1 - (1 - values.late_win) * step / max_steps);
}

}  // namespace powderkeg

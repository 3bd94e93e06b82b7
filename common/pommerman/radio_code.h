#pragma once

// What our agents tell each other in radio games, in two words of 1..7 (0 means silence).
//
// In even steps an agent names the row of its cell, in odd steps the column, each with what it is
// about to do along that line. Row or column (0..10) and plan (0..3) make one number
//
//   code = 4 * coordinate + plan         0..43
//   words = (1 + code / 7, 1 + code % 7)
//
// so that the mate knows the row and the column, one of them a step old. Words of other agents may
// mean anything; what cannot be a code is ignored.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/pommerman/types.h"

namespace powderkeg {

// One message, decoded.
struct RadioReport {
  enum class Axis : std::uint8_t { kRow, kColumn };
  enum class Plan : std::uint8_t {
    kStay,      // or move along the other axis
    kDecrease,  // the coordinate by one: up, left
    kIncrease,  // down, right
    kBomb,
  };
  Axis axis = Axis::kRow;
  int coordinate = 0;  // of the cell it decided on, 0..10
  Plan plan = Plan::kStay;

  friend bool operator==(const RadioReport&, const RadioReport&) = default;
};

// The words of an agent that plays `action` from `cell` after `step` steps.
[[nodiscard]] Message EncodeReport(int step, Cell cell, Action action);

// What a mate said with its action after `step` steps; nullopt for silence and foreign words.
[[nodiscard]] std::optional<RadioReport> DecodeReport(int step, const Message& message);

// Where the mate says it is. A mate that cannot have been where it said, because nobody gets that
// far in the steps between, speaks another language and is not believed for the rest of the game.
// A value; give it every message and every sight of the mate in a game in order.
class MateTracker {
 public:
  // `step`: of the observation that brought the message, which was sent a step earlier.
  void Hear(int step, const Message& message);
  // The mate stands in view in the observation after `step` steps. Comes after its message.
  void See(int step, Cell cell);

  // The cell where the mate is expected now, if both coordinates were heard and it is believed: off
  // by up to two rows or columns where a move failed or was not told yet.
  [[nodiscard]] std::optional<Cell> cell() const;

 private:
  static constexpr std::size_t kAxes = 2;
  // What is known for sure, if the mate speaks our language.
  struct Fix {
    int coordinate;
    int step;
  };
  void Take(RadioReport::Axis axis, Fix fix);

  std::array<std::optional<Fix>, kAxes> last_;      // heard or seen
  std::array<std::optional<int>, kAxes> expected_;  // now; once the coordinate was heard
  bool believed_ = true;
};

}  // namespace powderkeg

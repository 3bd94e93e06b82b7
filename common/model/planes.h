#pragma once

// A position as input planes of the network.

#include <array>
#include <cstdint>
#include <span>

#include "common/model/evaluator.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/symmetry.h"

namespace powderkeg {

// Planes of 11x11, row-major. "self" is the viewer; the others follow it in the order
// self + 1, self + 2, self + 3 (mod 4). Values lie in [-1, 1]; fog leaves every plane 0 in a cell.
//
//   0      rigid walls
//   1      wood
//   2..4   visible items: extra bomb, increase range, kick
//   5      bombs: 1 - life / 9
//   6      bombs: reach / 11, at most 1 (reach = blast strength - 1)
//   7      moving bombs: left -1, right +1
//   8      moving bombs: up +1, down -1
//   9      flames: remaining steps / 3 (life + 1; the longest of several)
//   10..13 living agents: self, self + 1, self + 2, self + 3
//   constant over the board:
//   14     own reach / 11, at most 1
//   15     own bombs on the board / 5, at most 1
//   16     own bomb capacity (ammo + own bombs on the board) / 5, at most 1
//   17     own kick
//   18..21 alive: self, self + 1, self + 2, self + 3
//   22     step / (max_steps - 1), at most 1
inline constexpr int kPlaneCount = 23;
inline constexpr int kOwnCellPlane = 10;
inline constexpr int kFirstConstantPlane = 14;
inline constexpr int kPlanesSize = kPlaneCount * kCellCount;

// Writes [plane][cell], 23 x 121 floats. Of the settings only max_steps matters.
void EncodePlanes(const GameSettings& settings, const Position& position,
                  std::span<float, kPlanesSize> planes);

// The same in bytes, a quarter of the size, for devices that expand them: [plane][cell], where
// plane p holds its value times the whole that it is a share of, and the step is split into plane
// 22 (step / 64) and one more plane (step % 64). Times PlaneScales, and the last two added, they
// are EncodePlanes but for rounding; where max_steps was passed, step shares above 1 must be cut.
inline constexpr int kStepBase = 64;
inline constexpr int kPlaneCountsSize = (kPlaneCount + 1) * kCellCount;
void EncodePlaneCounts(const Position& position, std::span<std::int8_t, kPlaneCountsSize> counts);
[[nodiscard]] std::array<float, kPlaneCount + 1> PlaneScales(const GameSettings& settings);

// The cell that plane 10 + `after` marks, that of the agent `after` places behind the viewer;
// kNoCell if it is dead or stands in fog. Requires 0 <= after < 4.
[[nodiscard]] Cell MarkedCell(const Position& position, int after);

}  // namespace powderkeg

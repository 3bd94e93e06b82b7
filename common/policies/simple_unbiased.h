#pragma once

// SimpleUnbiasedAgent ("SimpleCpp"), the rule-based opponent of the paper: it flees from bombs,
// bombs and approaches enemies, bombs wood, collects items, and else wanders. Per game it draws
// random orders of agents, rows and columns, so that it prefers no direction on average.

#include <array>

#include "common/policies/policy.h"

namespace powderkeg {

// The order in which its breadth-first search looks at neighbours.
inline constexpr std::array<Direction, 4> kSearchOrder = {Direction::kDown, Direction::kUp,
                                                          Direction::kRight, Direction::kLeft};

// Decide for PolicyKind::kSimpleUnbiased. It remembers its last four intended positions.
[[nodiscard]] Action DecideSimpleUnbiased(const PolicyView& view, const PolicyTraits& traits,
                                          PolicyMemory& memory, Rng& rng);

// ObserveMove for PolicyKind::kSimpleUnbiased. Exact unless a move was blocked: then the intended
// position is not seen and the own cell takes its place.
void ObserveSimpleUnbiased(Cell after, PolicyMemory& memory);

}  // namespace powderkeg

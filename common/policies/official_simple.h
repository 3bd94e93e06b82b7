#pragma once

// The official SimpleAgent ("SimplePy"), as a distribution: where Python's generator draws, ours
// draws with the same probabilities.

#include "common/policies/policy.h"

namespace powderkeg {

// Decide for PolicyKind::kOfficialSimple. It remembers the last six positions from which it
// wandered, and the direction of its last approach. Where the official code raises an exception (no
// passage in reach of its search when it considers a bomb) it stops.
[[nodiscard]] Action DecideOfficialSimple(const PolicyView& view, PolicyMemory& memory, Rng& rng);

// ObserveMove for PolicyKind::kOfficialSimple: an approximation, because what it remembers depends
// on which of its rules applied.
void ObserveOfficialSimple(Cell before, Cell after, PolicyMemory& memory);

}  // namespace powderkeg

#pragma once

// Policies that fit in a line or two.

#include "common/policies/policy.h"

namespace powderkeg {

// Uniform over the six actions.
[[nodiscard]] Action DecideRandom(Rng& rng);
// Uniform over the legal actions (LegalActions) other than bomb.
[[nodiscard]] Action DecideHarmless(const PolicyView& view, Rng& rng);

}  // namespace powderkeg

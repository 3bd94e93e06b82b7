#include "common/policies/plain_policies.h"

#include <bit>

#include "common/pommerman/step.h"

namespace powderkeg {

namespace {

constexpr ActionSet kBombSet = 1u << static_cast<int>(Action::kBomb);

}  // namespace

Action DecideRandom(Rng& rng) { return static_cast<Action>(rng.Below(kActionCount)); }

Action DecideHarmless(const PolicyView& view, Rng& rng) {
  unsigned choices = LegalActions(view.state, view.self) & static_cast<unsigned>(~kBombSet);
  const auto count = static_cast<std::uint32_t>(std::popcount(choices));
  for (std::uint32_t skip = rng.Below(count); skip > 0; --skip) choices &= choices - 1;
  return static_cast<Action>(std::countr_zero(choices));
}

}  // namespace powderkeg

#include "actors/search/foretelling.h"

#include <bit>

namespace powderkeg {

ForetoldActions ForetoldOf(const Foretelling& foretelling, AgentId viewer, AgentId agent) {
  return foretelling[static_cast<std::size_t>((agent - viewer + kAgentCount) % kAgentCount - 1)];
}

int SumOf(ForetoldActions foretold, ActionSet among) {
  int sum = 0;
  for (std::size_t a = 0; a < kActionCount; ++a) sum += Has(among, a) ? foretold[a] : 0;
  return sum;
}

Action DrawnAction(ForetoldActions foretold, ActionSet legal, Rng& rng) {
  const int sum = SumOf(foretold, legal);
  std::size_t action = static_cast<std::size_t>(std::countr_zero(legal));
  if (sum == 0) return static_cast<Action>(action);
  auto remaining = static_cast<int>(rng.Below(static_cast<std::uint32_t>(sum)));
  for (;; ++action) {
    if (Has(legal, action)) remaining -= foretold[action];
    if (remaining < 0) return static_cast<Action>(action);
  }
}

}  // namespace powderkeg

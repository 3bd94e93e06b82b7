#include "common/policies/policy.h"

#include <algorithm>
#include <span>

#include "common/base/check.h"
#include "common/policies/official_simple.h"
#include "common/policies/plain_policies.h"
#include "common/policies/simple_unbiased.h"

namespace powderkeg {

namespace {

constexpr std::array<std::string_view, 5> kNames = {"idle", "random", "harmless", "simple_unbiased",
                                                    "official_simple"};

}  // namespace

std::string_view NameOf(PolicyKind kind) { return kNames[static_cast<int>(kind)]; }

std::optional<PolicyKind> PolicyKindFor(std::string_view name) {
  const auto found = std::ranges::find(kNames, name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<PolicyKind>(found - kNames.begin());
}

PolicyTraits PolicyTraits::Draw(Rng& rng) {
  PolicyTraits traits;
  rng.Shuffle(std::span<std::uint8_t>(traits.agent_order));
  rng.Shuffle(std::span<std::uint8_t>(traits.row_order));
  rng.Shuffle(std::span<std::uint8_t>(traits.column_order));
  return traits;
}

Action Decide(PolicyKind kind, const PolicyView& view, const PolicyTraits& traits,
              PolicyMemory& memory, Rng& rng) {
  DCHECK(view.state.agents[view.self].alive);
  switch (kind) {
    case PolicyKind::kIdle: return Action::kStop;
    case PolicyKind::kRandom: return DecideRandom(rng);
    case PolicyKind::kHarmless: return DecideHarmless(view, rng);
    case PolicyKind::kSimpleUnbiased: return DecideSimpleUnbiased(view, traits, memory, rng);
    case PolicyKind::kOfficialSimple: return DecideOfficialSimple(view, memory, rng);
  }
  return Action::kStop;
}

void ObserveMove(PolicyKind kind, Cell before, Cell after, PolicyMemory& memory) {
  if (kind == PolicyKind::kSimpleUnbiased) ObserveSimpleUnbiased(after, memory);
  if (kind == PolicyKind::kOfficialSimple) ObserveOfficialSimple(before, after, memory);
}

}  // namespace powderkeg

#include "common/policies/policy.h"

#include <algorithm>
#include <span>

#include "common/base/check.h"
#include "common/policies/official_simple.h"
#include "common/policies/plain_policies.h"
#include "common/policies/simple_unbiased.h"

namespace powderkeg {

namespace {

// Of ObserveStep: after so many draws an explanation is unlikely to come.
constexpr int kExplanationDraws = 8;

constexpr std::array<std::string_view, 5> kNames = {"idle", "random", "harmless", "simple_unbiased",
                                                    "official_simple"};

// Whether the agent may have ended up as seen by this action. Who stayed may have been blocked.
bool Explains(Action action, const State& before, const State& after, AgentId agent) {
  const Cell from = before.agents[agent].cell;
  const Cell to = after.agents[agent].cell;
  const bool laid = after.bomb_cells.Has(from) && !before.bomb_cells.Has(from);
  if (to != from) return IsMove(action) && Neighbour(from, DirectionOf(action)) == to;
  return laid == (action == Action::kBomb);
}

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

void ObserveStep(PolicyKind kind, const PolicyView& view, const State& after,
                 const PolicyTraits& traits, PolicyMemory& memory, Rng& rng) {
  for (int draw = 0; draw < kExplanationDraws; ++draw) {
    PolicyMemory remembered = memory;
    const Action action = Decide(kind, view, traits, remembered, rng);
    if (!Explains(action, view.state, after, view.self)) continue;
    memory = remembered;
    return;
  }
  ObserveMove(kind, view.state.agents[view.self].cell, after.agents[view.self].cell, memory);
}

}  // namespace powderkeg

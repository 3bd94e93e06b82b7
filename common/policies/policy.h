#pragma once

// Rule-based agents as values: used as agents, as opponent models inside the search, and by the
// learner to verify games.

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "common/base/rng.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"

namespace powderkeg {

enum class PolicyKind : std::uint8_t {
  kIdle,            // always stops
  kRandom,          // uniform over the six actions
  kHarmless,        // uniform over the legal actions other than bomb
  kSimpleUnbiased,  // "SimpleCpp", simple_unbiased.h
  kOfficialSimple,  // the official SimpleAgent, "SimplePy", official_simple.h
};

// "idle", "random", "harmless", "simple_unbiased", "official_simple".
[[nodiscard]] std::string_view NameOf(PolicyKind kind);
[[nodiscard]] std::optional<PolicyKind> PolicyKindFor(std::string_view name);

// What a policy may look at: the parts of `state` within `visible`, and who it is. Policies never
// read hidden items, other agents' statistics or the owners of bombs. Cells outside `visible` are
// fog; agents and bombs there are not seen.
struct PolicyView {
  const State& state;
  const GameSettings& settings;
  AgentId self;
  BitBoard visible = BitBoard::All();
};

// What is drawn once at the start of a game and stays hidden from the others. 26 bytes.
struct PolicyTraits {
  std::array<std::uint8_t, kAgentCount> agent_order = {0, 1, 2, 3};
  std::array<std::uint8_t, kBoardSize> row_order = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  std::array<std::uint8_t, kBoardSize> column_order = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10};

  [[nodiscard]] static PolicyTraits Draw(Rng& rng);
  friend bool operator==(const PolicyTraits&, const PolicyTraits&) = default;
};

// What a policy remembers from one decision to the next. 8 bytes; each kind uses what it needs.
// The default value is the memory at the start of a game.
struct PolicyMemory {
  // The last positions, oldest first, [0, recent_count): each (row + 1) * 13 + column + 1, so that
  // positions just off the board have a number too.
  std::array<std::uint8_t, 6> recent{};
  std::uint8_t recent_count = 0;
  std::uint8_t previous_direction = 0;  // official_simple: 0 none, 1..4

  friend bool operator==(const PolicyMemory&, const PolicyMemory&) = default;
};

// The number of a remembered position; row and column may be -1 to 11.
[[nodiscard]] constexpr std::uint8_t RememberedPosition(int row, int column) {
  return static_cast<std::uint8_t>((row + 1) * 13 + column + 1);
}

// The action of `view.self`, which must be alive. Updates the memory; draws from `rng` only where
// the decision is random. Integers only: the same on every machine.
[[nodiscard]] Action Decide(PolicyKind kind, const PolicyView& view, const PolicyTraits& traits,
                            PolicyMemory& memory, Rng& rng);

// Keeps the memory of a modelled agent in step with what was seen of it: after it decided on
// `before` and was then seen on `after`, replaces what a Decide would have remembered. Call it
// once per real step of a living agent instead of Decide.
void ObserveMove(PolicyKind kind, Cell before, Cell after, PolicyMemory& memory);

// As ObserveMove, closer to the truth: where the positions before and after are known, asks the
// policy what it would have remembered after an action that explains what was seen. `view` is what
// the agent decided on, `traits` a guess. Costs a few decisions. Falls back on ObserveMove where no
// action explains it.
void ObserveStep(PolicyKind kind, const PolicyView& view, const State& after,
                 const PolicyTraits& traits, PolicyMemory& memory, Rng& rng);

}  // namespace powderkeg

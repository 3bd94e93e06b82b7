#pragma once

// How a search thinks. Every option with its range, default and meaning: search_options.inc.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/config/options.h"

namespace powderkeg {

// Whose moves branch inside the tree.
enum class TreeKind : std::uint8_t {
  kOnePlayer,  // the searching agent's
  kTwoPlayer,  // the searching agent's, then one living enemy's, in every environment step
};

// Which enemy moves in a two-player tree; chosen anew in every environment step.
enum class SimulatedOpponent : std::uint8_t {
  kClosest,        // by Manhattan distance, ties by lowest id
  kMostDangerous,  // whose bomb, laid now, would reach the searching agent; among several, the
                   // closest; without one, the closest
};

// How it moves.
enum class SimulatedMoves : std::uint8_t {
  kAgainstSelf,  // to the searching agent's harm: backed up tends to be the worst outcome
  kAsForetold,   // each move as often as its prior says: the mean over outcomes
};

// How the simulations are shared out among the actions of the root.
enum class RootSearch : std::uint8_t {
  kPuct,    // as inside the tree, with noise
  kGumbel,  // sequential halving of Gumbel-drawn candidates (gumbel_root.h); the improved policy is
            // learned. Noise, exploratory starts, forced playouts, root_unvisited_value and the
            // options of the move's choice do not apply
};

// What stands in for an agent that is not searched.
enum class OpponentModel : std::uint8_t {
  kIdle,
  kRandom,
  kHarmless,
  kSimpleUnbiased,
  kOfficialSimple,
  kPredicted,   // what the evaluation of the position foretells of it: asks nothing more. Nothing
                // (a stop) where the network foretells nobody or the agent is out of sight
  kRawNetwork,  // argmax of the network's policy for that agent over its legal actions
  kObserved,    // the rule-based policy that explains its actions in this game best so far
  kChosen,      // the same, or kPredicted if that explains them better (model_choice.h)
};
inline constexpr std::size_t kOpponentModelCount = 9;
using ModelOfEach = std::array<OpponentModel, 3>;  // of the three others
inline constexpr ModelOfEach kAllObserved = {OpponentModel::kObserved, OpponentModel::kObserved,
                                             OpponentModel::kObserved};

// What the models of rule-based opponents remember from the real game.
enum class ModelMemory : std::uint8_t {
  kReset,         // nothing: empty at every move (as published)
  kSynchronized,  // the positions where the opponent was seen
  kInferred,      // what explains its actions so far: what it remembers, and its hidden orders
};

[[nodiscard]] Names NamesOf(TreeKind);
[[nodiscard]] Names NamesOf(SimulatedOpponent);
[[nodiscard]] Names NamesOf(SimulatedMoves);
[[nodiscard]] Names NamesOf(RootSearch);
[[nodiscard]] Names NamesOf(OpponentModel);
[[nodiscard]] Names NamesOf(ModelMemory);

// A value. The defaults are this project's best; PaperSettings() are the published ones.
struct SearchSettings {
#define OPTION(type, name, initial, ...) type name = initial;
#include "common/config/search_options.inc"

  friend bool operator==(const SearchSettings&, const SearchSettings&) = default;
};

// As published (Weil et al. 2023): SimpleUnbiased models, reset at each move, step limit unknown,
// no reuse, exploratory starts. That its nodes choose among their visited children and the next two
// unvisited by prior changes nothing: of the unvisited ones, all of equal Q, the next by prior
// always scores highest (tree_test ChoosesAmongVisitedAndTheNextTwo).
[[nodiscard]] SearchSettings PaperSettings();
// For self-play: a Gumbel root, WithoutAids.
[[nodiscard]] SearchSettings GumbelSettings();
// For self-play, too, after Wu 2019 ("Accelerating self-play learning in Go", 3.1 and 3.2): a
// quarter of the searches are full ones and teach a policy, with forced playouts that are pruned
// from the target; the others are short. WithoutAids.
[[nodiscard]] SearchSettings KataGoSettings();

// The same search by its evaluator alone: no caution, no weight of anybody's room, priors as they
// are.
[[nodiscard]] SearchSettings WithoutAids(SearchSettings settings);

// Whether somebody's model is kPredicted, or may become so.
[[nodiscard]] bool Predicts(const SearchSettings& settings);

// The same search as strong as it can play: no noise, no drawing of moves, no short searches.
[[nodiscard]] SearchSettings WithoutExploration(SearchSettings settings);

// Every option. The first is "preset" (default | paper | gumbel | katago), which replaces all
// others by those of the settings above.
[[nodiscard]] OptionTable<SearchSettings> SearchOptions();

}  // namespace powderkeg

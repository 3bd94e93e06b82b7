#pragma once

// How a search thinks: every knob by name, for config files and agent specifications.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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
  kRawNetwork,  // argmax of the network's policy for that agent over its legal actions
  kObserved,    // the rule-based policy that foretold its actions in this game best so far
};

// What the models of rule-based opponents remember from the real game.
enum class ModelMemory : std::uint8_t {
  kReset,         // nothing: empty at every move (as published)
  kSynchronized,  // the positions where the opponent was seen
  kInferred,      // what explains its actions so far: what it remembers, and its hidden orders
};

// A value. The defaults are this project's best; PaperSettings() are the published ones.
struct SearchSettings {
  int simulations = 250;  // per move, besides the evaluation of the root
  TreeKind tree = TreeKind::kOnePlayer;
  SimulatedOpponent simulated_opponent = SimulatedOpponent::kClosest;
  // An enemy farther away (Manhattan) than this does not branch; with none in reach the step is
  // one-player.
  int simulated_opponent_reach = 20;
  // Models of the agents self + 1, self + 2, self + 3 (mod 4). In team modes the second is the
  // mate.
  std::array<OpponentModel, 3> opponents = {OpponentModel::kObserved, OpponentModel::kObserved,
                                            OpponentModel::kObserved};
  std::optional<OpponentModel> mate_model;  // of the mate in team modes, instead of opponents[1]
  // In the first steps of a simulation, this many, all models are the network (as kRawNetwork);
  // then `opponents` says. Nodes of a kept tree stay as they were decided.
  int raw_network_depth = 0;
  ModelMemory memory = ModelMemory::kInferred;

  // Selection: Q + c(N) P sqrt(N) / (1 + n), c(N) = c_puct_init + ln((N + base + 1) / base).
  double c_puct_init = 2.5;
  double c_puct_base = 19652;
  double unvisited_value = -1;  // Q of an action not yet tried, its mover's view: deep, thin
                                // trees
  // The same at the root. +1: every legal move is tried, so that visits to learn from do not repeat
  // what the policy left out.
  double root_unvisited_value = -1;
  bool renormalise_priors = false;  // after dropping illegal actions
  bool action_filter = true;        // only LegalActions; otherwise all six

  // Root.
  RootSearch root = RootSearch::kPuct;
  int gumbel_considered = 6;  // actions that sequential halving begins with; 6: all legal ones
  // Simulations of the first of many halvings, each of twice as many as the one before: for a
  // search that a clock will end, nobody knows when. 0: one halving of all simulations.
  int gumbel_first_halving = 0;
  double gumbel_scale = 1;     // of the Gumbel numbers; 0: none, for the strongest move
  double gumbel_c_visit = 50;  // as published for board games, as c_scale is
  double gumbel_c_scale = 1;
  double noise_alpha = 0.2;      // Dirichlet
  double noise_weight = 0.25;    // share of noise in the root's priors; 0: none
  double exploratory_start = 0;  // probability that a simulation starts with a random action
  double temperature = 0;        // of the move's choice by visits; 0: the most visited
  double q_weight = 0;           // share of the values in the choice by visits
  double q_veto = 0;  // prefer the action of the best value if it leads by more than this; 0: never

  double forced_playouts = 0;  // k (root_policy.h); 2 as published; 0: off

  // Playout cap randomisation: this share of the moves is searched with all simulations, the others
  // with fast_simulations, without noise of any kind, exploratory starts, forced playouts and
  // temperature, and not to be learned as policies.
  double full_search_share = 1;
  int fast_simulations = 50;

  // Ends, values from the searching agent's view.
  double draw_value = 0;            // of a tie
  double late_win_value = 1;        // of a win in the last step (see OutcomeValues)
  bool step_limit = true;           // whether the search knows that a game ends after max_steps
  bool mate_value_on_death = true;  // team: after own death the network judges for the mate;
                                    // otherwise that is worth -0.5
  // Won and lost positions are proven up the tree, given what the models do and the actions that
  // are searched: lost actions get no more simulations, are not chosen and not learned; a search
  // ends when its root is proven. As published: lowers win rates, as models err.
  bool terminal_solver = false;

  bool tree_reuse = true;  // keep the subtree of what really happened
  // Leaves per Gather. More than one fills batches from one tree at some cost in strength.
  int leaves_per_batch = 1;

  friend bool operator==(const SearchSettings&, const SearchSettings&) = default;
};

// As published (paper.md): SimpleUnbiased models, reset at each move, step limit unknown, no reuse,
// exploratory starts. That its nodes choose among their visited children and the next two unvisited
// by prior changes nothing: of the unvisited ones, all of equal Q, the next by prior always scores
// highest (tree_test ChoosesAmongVisitedAndTheNextTwo).
[[nodiscard]] SearchSettings PaperSettings();

// The defaults with a Gumbel root.
[[nodiscard]] SearchSettings GumbelSettings();
// For self-play, after Wu 2019 ("Accelerating self-play learning in Go", 3.1 and 3.2): a quarter of
// the searches are full ones and teach a policy, with forced playouts that are pruned from the
// target; the others are short.
[[nodiscard]] SearchSettings KataGoSettings();

// Sets one option from text. Throws Error for an unknown name (lists the known ones) and for a bad
// value (says the value and what is allowed). The option "preset" (default | paper | gumbel |
// katago) replaces every setting: it must come first.
void SetOption(SearchSettings& settings, std::string_view name, std::string_view value);

// The defaults changed by the options in order, except that a preset is applied first. Throws
// Error.
[[nodiscard]] SearchSettings SearchSettingsFrom(
    std::span<const std::pair<std::string, std::string>> options);

// The same from "simulations=250,opponents=simple_unbiased"; empty text gives the defaults.
[[nodiscard]] SearchSettings ParseSearchSettings(std::string_view text);

struct SearchOption {
  std::string name;
  std::string value;  // in the given settings
  std::string help;   // one line with the allowed values
};
// Every option but "preset".
[[nodiscard]] std::vector<SearchOption> ListOptions(const SearchSettings& settings);

// The options that differ from the defaults, as ParseSearchSettings reads them.
[[nodiscard]] std::string ToText(const SearchSettings& settings);

}  // namespace powderkeg

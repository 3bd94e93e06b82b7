#pragma once

// Which move of the simulated enemy a simulation goes through, in a two-player tree.

#include "actors/search/tree.h"
#include "common/config/search_settings.h"

namespace powderkeg {

// The actions of a ply that are considered at its number of visits: all legal ones, or with
// widening the ceil(widening visits^widening_exponent) likeliest of them (Couetoux et al. 2011,
// "Continuous upper confidence trees"), one at least.
[[nodiscard]] ActionSet ConsideredMoves(const SearchSettings& settings, const Node& ply);

// One of them. simulated_moves=against_self: what is worst for the searching agent, by the rule of
// selection, so that the value of the ply tends to that of the worst outcome. as_foretold: the one
// that lags most behind its prior (the largest prior / (1 + visits), d'Hondt's rule), so that
// visits tend to the priors' shares and the value of the ply to the mean over outcomes.
[[nodiscard]] Action ChooseEnemyMove(const SearchSettings& settings, const Tree& tree,
                                     const Node& ply);

}  // namespace powderkeg

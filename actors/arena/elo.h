#pragma once

// Elo differences of games with any number of sides.

#include <span>

#include "common/base/stats.h"
#include "common/pommerman/game_settings.h"

namespace powderkeg {

// A game of n sides has one point: the winner's, or shared by all. Elo is taken from Luce's choice
// rule: among sides of strengths s_i = 10^(Elo_i / 400) side i has s_i / (s_1 + ... + s_n) of the
// point. With two sides that is the usual definition; equal sides are 0 apart however many.

// Sides of a game: four, in teams and duels two.
[[nodiscard]] int SideCount(Mode mode);

// One side's part of the point for an outcome: +1 win, 0 tie, -1 loss.
[[nodiscard]] double PointsFor(int outcome, int sides);

// The Elo of a side over the average of its opponents whose mean points are `points` (0 to 1;
// infinite at the ends).
[[nodiscard]] double EloFromPoints(double points, int sides);

// The same with a 95 % interval (ScoreInterval). Requires games.
[[nodiscard]] EloEstimate EloOverOpponents(const MatchScore& match, int sides);

// Elo of one agent over another that played the same games against the same opponents; entry i of
// both are their points in game i. The interval (95 %, delta method) makes use of the pairing; it
// and the difference are infinite where one of them won all or nothing. Requires games.
[[nodiscard]] EloEstimate PairedElo(std::span<const double> points,
                                    std::span<const double> base_points, int sides);

}  // namespace powderkeg

#pragma once

// Strength of many players from games in pairs.

#include <cstddef>
#include <span>
#include <vector>

#include "common/base/stats.h"

namespace powderkeg {

// Games between two players.
struct PairScore {
  std::size_t first = 0;
  std::size_t second = 0;
  MatchScore score;  // of the first
};

struct Rating {
  double elo = 0;            // over the mean of all players
  double half_interval = 0;  // of 95 %; infinite without games
};

// The strengths under which these results are the most likely: Bradley and Terry 1952, fitted by
// minorisation and maximisation (Hunter 2004, eq. 3), a tie counting as half a win and half a loss.
// Everybody is taken to have tied once with a player of mean strength, so that nobody is infinitely
// strong. The interval is that of a player by itself, the others' strengths given.
[[nodiscard]] std::vector<Rating> RatePlayers(std::size_t players,
                                              std::span<const PairScore> pairs);

}  // namespace powderkeg

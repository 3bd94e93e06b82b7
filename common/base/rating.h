#pragma once

// Strength of many players from games in pairs.

#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
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

  friend bool operator==(const Rating&, const Rating&) = default;
};

// The strengths under which these results are the most likely: Bradley and Terry 1952, fitted by
// minorisation and maximisation (Hunter 2004, eq. 3), a tie counting as half a win and half a loss.
// Everybody is taken to have tied once with a player of mean strength, so that nobody is infinitely
// strong. The interval is that of a player by itself, the others' strengths given.
[[nodiscard]] std::vector<Rating> RatePlayers(std::size_t players,
                                              std::span<const PairScore> pairs);

// How far somebody came in a game of several: whoever won is before all others, then whoever lasted
// longer. Where a team's result counts for all of it, nobody's steps do: leave them 0.
struct Place {
  bool won = false;
  int lasted = 0;  // steps

  friend auto operator<=>(const Place&, const Place&) = default;
};
// Result of the first against the second: +1, 0 or -1.
[[nodiscard]] int Compare(const Place& first, const Place& second);

// By two different names; the score is the first one's.
using NamedScores = std::map<std::pair<std::string, std::string>, MatchScore>;

struct RatedName {
  std::string name;
  std::uint64_t games = 0;  // pairs it was in
  Rating rating;
};
// Everybody of the pairs, the strongest first.
[[nodiscard]] std::vector<RatedName> RateNames(const NamedScores& pairs);

}  // namespace powderkeg

#pragma once

// How players and versions fare against each other, and which past self to meet next.

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/base/rating.h"
#include "common/base/rng.h"
#include "learner/league/score_file.h"
#include "learner/replay/lessons.h"

namespace powderkeg {

// A version of the run's weights, whatever player used it, or a player without any.
struct Contestant {
  std::string player;         // empty where there is a version
  std::uint32_t version = 0;  // 0: none, or weights of a file

  [[nodiscard]] std::string name() const;
  friend auto operator<=>(const Contestant&, const Contestant&) = default;
};

// Whoever outlives another has beaten it; who died in the same step, or lived to a tie, tied. In
// team modes the team's result counts for both. Pairs of mates, of equal contestants and of those
// that outlived a game that was not played to its end do not count. Thread-safe.
class League {
 public:
  // Reads league.csv of a run, if it is there; rows of iterations later than `iterations_done` are
  // of iterations that are now repeated, and dropped. Throws Error with the line.
  League(const std::filesystem::path& file, std::vector<std::string> players, int iterations_done);

  // The results of an iteration, durable when it returns. Throws Error. One thread.
  void Add(int iteration, std::span<const GameResult> results);

  // The version to meet of those from `oldest` to before `newest`: from newest - 1, - 2, - 4, ...,
  // the more likely the less newer versions won against it, as (1 - p)^2 (prioritised fictitious
  // self-play, Vinyals et al. 2019). 0: there is none.
  [[nodiscard]] std::uint32_t DrawPast(std::uint32_t oldest, std::uint32_t newest, Rng& rng) const;

  // Everybody that has met somebody, the strongest first.
  [[nodiscard]] std::vector<RatedName> Ratings() const;
  // The same as CSV: name, games, elo and the ends of its 95 % interval.
  [[nodiscard]] std::string RatingsCsv() const;
  // Of the newest version that was met, over the oldest; nullopt while there are less than two.
  [[nodiscard]] std::optional<Rating> Progress() const;

 private:
  using Pair = std::pair<Contestant, Contestant>;  // ascending

  [[nodiscard]] Contestant ContestantOf(const Finish& finish) const;
  void AddPair(int iteration, const GameResult& result, AgentId first, AgentId second);
  void AddScore(int iteration, const Pair& pair, const MatchScore& score);

  const ScoreFile file_;
  const std::vector<std::string> players_;
  mutable std::mutex mutex_;  // guards the rest
  ScoreRows rows_;
  std::map<Pair, MatchScore> totals_;  // of the first contestant
};

}  // namespace powderkeg

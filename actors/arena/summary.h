#pragma once

// What a match says about the agent it measured, and about two agents on the same boards.

#include <array>
#include <cstdint>

#include "actors/arena/match.h"
#include "common/base/stats.h"
#include "common/config/search_settings.h"

namespace powderkeg {

// A match as seen by the measured agent: role 0, and role 2 where it is its own mate. "Per game"
// means per game and agent.
struct MatchSummary {
  MatchScore score;
  std::uint64_t deaths = 0;         // of agents, whatever came of the game
  std::uint64_t agents = 0;         // that could die: games, twice as many with itself as mate
  EloEstimate elo;                  // over the average opponent (elo.h)
  RunningStatistics steps;          // per game
  double moves_per_game = 0;        // steps it lived
  double mean_depth = 0;            // environment steps; 0 without searches
  double variation_length = 0;      // environment steps of the principal variation, mean
  double ms_per_move = 0;           // of one thread, the whole game included
  double simulations_per_s = 0;     // of all threads
  double mean_batch = 0;            // positions per evaluation
  double prediction_accuracy = -1;  // at the root; -1: nothing predicted
  // Shares of these predictions by the model that its opponent was taken for.
  std::array<double, kOpponentModelCount> taken_for{};
  double bombs_per_game = 0;       // laid
  double kicks_per_game = 0;       // bombs set rolling
  double kills_per_game = 0;       // enemies that died in flames of its bombs
  double mate_kills_per_game = 0;  // and mates
  double own_deaths_per_game = 0;  // share of games in which its own bombs alone killed it
  double cells_in_window = 0;      // distinct cells in 20 moves in a row; 0: it never lived so long
  std::array<double, kActionCount> action_shares{};  // sum 1
  std::array<std::uint64_t, kCellCount> heat_map{};  // SeatStatistics::cells
};

[[nodiscard]] MatchSummary Summarize(const MatchSettings& settings, const Match& match);

// How much better `candidate` did than `base` on the same boards, with 95 % intervals from the
// differences game by game.
struct Difference {
  double win_rate = 0;
  Interval win_interval;
  double score = 0;  // points per game, a tie counts 1/2
  Interval score_interval;
  EloEstimate elo;  // PairedElo
};
// Over the games that both played. Requires one at least.
[[nodiscard]] Difference Compare(const MatchSettings& settings, const Match& candidate,
                                 const Match& base);

}  // namespace powderkeg

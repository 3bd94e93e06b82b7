#pragma once

// What a match says: figures with intervals, as a table, JSON and CSV.

#include <array>
#include <span>
#include <string>
#include <vector>

#include "actors/arena/match.h"
#include "common/base/stats.h"

namespace powderkeg {

// A match as seen by its candidate: role 0, in team modes together with its mate.
struct MatchSummary {
  MatchScore score;
  RunningStatistics steps;                           // per game
  double mean_depth = 0;                             // environment steps; 0 without searches
  double ms_per_move = 0;                            // of one thread, the whole game included
  double simulations_per_s = 0;                      // of all threads
  double mean_batch = 0;                             // positions per evaluation
  double moves_per_game = 0;                         // steps the candidate lived
  double prediction_accuracy = -1;                   // at the root; -1: nothing predicted
  std::array<double, kActionCount> action_shares{};  // sum 1
};

[[nodiscard]] MatchSummary Summarize(const MatchSettings& settings, const Match& match);

// How much better `candidate` did than `base` on the same boards, with 95 % intervals from the
// differences game by game.
struct Difference {
  double win_rate = 0;
  Interval win_interval;
  double score = 0;  // points per game, a tie counts 1/2
  Interval score_interval;
};
// Requires matches of the same number of games.
[[nodiscard]] Difference Compare(const Match& candidate, const Match& base);

// One measured agent of a report.
struct Contender {
  std::string agent;  // as specified
  std::string opponents;
  Match match;
  MatchSummary summary;
};

// For people: a block per contender, then the differences to the first.
[[nodiscard]] std::string ReportText(std::span<const Contender> contenders);
// One JSON object: {"contenders": [{"agent", "opponents", "games", "win", "win_low", ...}, ...]};
// rates are 0 to 1, intervals 95 %.
[[nodiscard]] std::string ReportJson(std::span<const Contender> contenders);
// One line per contender and game: agent,game,seed,seat,outcome,steps,moves,simulations.
[[nodiscard]] std::string ReportCsv(std::span<const Contender> contenders);

}  // namespace powderkeg

#include "actors/arena/summary.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "actors/arena/elo.h"
#include "common/base/check.h"

namespace powderkeg {
namespace {

double Ratio(double part, double whole) { return whole == 0 ? 0.0 : part / whole; }

SeatStatistics MeasuredStatistics(const Match& match) {
  SeatStatistics sum;
  for (const PlayedGame& game : match.games) {
    for (const int role : match.roles) sum += game.statistics[role];
  }
  return sum;
}

// What the measured agent did.
void SummarizeActs(const SeatStatistics& sum, double games, MatchSummary& summary) {
  summary.moves_per_game = Ratio(sum.moves, games);
  summary.bombs_per_game = Ratio(sum.bombs, games);
  summary.kicks_per_game = Ratio(sum.kicks, games);
  summary.kills_per_game = Ratio(sum.kills, games);
  summary.mate_kills_per_game = Ratio(sum.mate_kills, games);
  summary.own_deaths_per_game = Ratio(sum.own_deaths, games);
  summary.cells_in_window = Ratio(static_cast<double>(sum.window_cells), sum.windows);
  for (std::size_t action = 0; action < kActionCount; ++action) {
    summary.action_shares[action] = Ratio(sum.actions[action], sum.moves);
  }
  std::ranges::copy(sum.cells, summary.heat_map.begin());
}

// How it thought.
void SummarizeSearch(const SeatStatistics& sum, const Match& match, MatchSummary& summary) {
  summary.mean_depth = Ratio(sum.depth_sum, sum.searches);
  summary.variation_length = Ratio(static_cast<double>(sum.variation_sum), sum.searches);
  summary.ms_per_move = Ratio(1e3 * match.thread_seconds, static_cast<double>(match.timed_moves));
  summary.simulations_per_s = Ratio(static_cast<double>(match.metrics.simulations), match.seconds);
  summary.mean_batch = match.metrics.mean_batch();
  if (sum.predictions > 0) {
    summary.prediction_accuracy = Ratio(sum.predictions_right, sum.predictions);
    for (std::size_t model = 0; model < kOpponentModelCount; ++model) {
      summary.taken_for[model] = Ratio(sum.taken_for[model], sum.predictions);
    }
  }
}

std::vector<double> PointsOf(const Match& match, std::size_t games, int sides) {
  std::vector<double> points;
  for (std::size_t i = 0; i < games; ++i) {
    points.push_back(PointsFor(match.games[i].outcomes[0], sides));
  }
  return points;
}

}  // namespace

MatchSummary Summarize(const MatchSettings& settings, const Match& match) {
  CHECK(!match.games.empty());
  MatchSummary summary;
  for (const PlayedGame& game : match.games) {
    const int outcome = game.outcomes[0];
    summary.score.Add(outcome);
    summary.steps.Add(game.steps);
    for (const int role : match.roles) summary.deaths += game.died[role] ? 1 : 0;
  }
  summary.agents = match.games.size() * match.roles.size();
  summary.elo = EloOverOpponents(summary.score, SideCount(settings.game.mode));
  const SeatStatistics sum = MeasuredStatistics(match);
  SummarizeActs(sum, static_cast<double>(summary.agents), summary);
  SummarizeSearch(sum, match, summary);
  return summary;
}

Difference Compare(const MatchSettings& settings, const Match& candidate, const Match& base) {
  const std::size_t games = std::min(candidate.games.size(), base.games.size());
  CHECK(games > 0);
  RunningStatistics wins;
  RunningStatistics points;
  for (std::size_t i = 0; i < games; ++i) {
    const int ours = candidate.games[i].outcomes[0];
    const int theirs = base.games[i].outcomes[0];
    wins.Add((ours > 0 ? 1 : 0) - (theirs > 0 ? 1 : 0));
    points.Add(0.5 * (ours - theirs));
  }
  const int sides = SideCount(settings.game.mode);
  return {wins.mean(), wins.MeanInterval(), points.mean(), points.MeanInterval(),
          PairedElo(PointsOf(candidate, games, sides), PointsOf(base, games, sides), sides)};
}

}  // namespace powderkeg

#include "actors/arena/elo.h"

#include <cmath>
#include <cstddef>
#include <limits>

#include "common/base/check.h"

namespace powderkeg {
namespace {

double MeanOf(std::span<const double> samples) {
  RunningStatistics statistics;
  for (const double sample : samples) statistics.Add(sample);
  return statistics.mean();
}

// How fast Elo grows with the points.
double EloSlope(double points) { return 400 / (std::log(10) * points * (1 - points)); }

bool IsInside(double points) { return points > 0 && points < 1; }

}  // namespace

int SideCount(Mode mode) { return mode == Mode::kFreeForAll ? kAgentCount : 2; }

double PointsFor(int outcome, int sides) {
  if (outcome == 0) return 1.0 / sides;
  return outcome > 0 ? 1 : 0;
}

double EloFromPoints(double points, int sides) {
  return EloFromScore(points) + 400 * std::log10(sides - 1.0);
}

EloEstimate EloOverOpponents(const MatchScore& match, int sides) {
  const std::uint64_t games = match.games();
  CHECK(games > 0);
  const double sum = static_cast<double>(match.wins) + static_cast<double>(match.ties) / sides;
  const double points = sum / static_cast<double>(games);
  const Interval interval = ScoreInterval(points, games);
  return {EloFromPoints(points, sides),
          {EloFromPoints(interval.low, sides), EloFromPoints(interval.high, sides)}};
}

EloEstimate PairedElo(std::span<const double> points, std::span<const double> base_points,
                      int sides) {
  CHECK(points.size() == base_points.size() && !points.empty());
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double mean = MeanOf(points);
  const double base = MeanOf(base_points);
  const double elo = mean == base ? 0 : EloFromPoints(mean, sides) - EloFromPoints(base, sides);
  if (!IsInside(mean) || !IsInside(base)) return {elo, {-kInfinity, kInfinity}};
  RunningStatistics differences;  // of the linearised Elo, game by game
  for (std::size_t i = 0; i < points.size(); ++i) {
    differences.Add(EloSlope(mean) * points[i] - EloSlope(base) * base_points[i]);
  }
  const double radius = 0.5 * (differences.MeanInterval().high - differences.MeanInterval().low);
  return {elo, {elo - radius, elo + radius}};
}

}  // namespace powderkeg

#include "common/base/stats.h"

#include <cmath>
#include <limits>

#include "common/base/check.h"

namespace powderkeg {
Interval WilsonInterval(std::uint64_t successes, std::uint64_t trials, double quantile) {
  CHECK(successes <= trials, successes, " of ", trials);
  if (trials == 0) return {0, 1};
  return ScoreInterval(static_cast<double>(successes) / static_cast<double>(trials), trials,
                       quantile);
}

Interval ScoreInterval(double mean, std::uint64_t trials, double quantile) {
  CHECK(mean >= 0 && mean <= 1, mean);
  if (trials == 0) return {0, 1};
  const double n = static_cast<double>(trials);
  const double z2 = quantile * quantile;
  const double centre = mean + z2 / (2 * n);
  const double radius = quantile * std::sqrt(mean * (1 - mean) / n + z2 / (4 * n * n));
  const double scale = 1 + z2 / n;
  return {mean <= 0 ? 0 : (centre - radius) / scale, mean >= 1 ? 1 : (centre + radius) / scale};
}

void RunningStatistics::Add(double sample) {
  ++count_;
  const double distance = sample - mean_;
  mean_ += distance / static_cast<double>(count_);
  squares_ += distance * (sample - mean_);
}

RunningStatistics& RunningStatistics::operator+=(const RunningStatistics& other) {
  if (other.count_ == 0) return *this;
  const double n = static_cast<double>(count_);
  const double m = static_cast<double>(other.count_);
  const double distance = other.mean_ - mean_;
  mean_ += distance * m / (n + m);
  squares_ += other.squares_ + distance * distance * n * m / (n + m);
  count_ += other.count_;
  return *this;
}

double RunningStatistics::variance() const {
  return count_ < 2 ? 0.0 : squares_ / static_cast<double>(count_ - 1);
}

double RunningStatistics::standard_deviation() const { return std::sqrt(variance()); }

Interval RunningStatistics::MeanInterval(double quantile) const {
  if (count_ == 0) return {mean_, mean_};
  const double radius = quantile * std::sqrt(variance() / static_cast<double>(count_));
  return {mean_ - radius, mean_ + radius};
}

MatchScore& MatchScore::operator+=(const MatchScore& other) {
  wins += other.wins;
  ties += other.ties;
  losses += other.losses;
  return *this;
}

double EloFromScore(double score) {
  if (score <= 0) return -std::numeric_limits<double>::infinity();
  if (score >= 1) return std::numeric_limits<double>::infinity();
  return 400 * std::log10(score / (1 - score));
}

}  // namespace powderkeg

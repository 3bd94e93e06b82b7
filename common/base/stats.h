#pragma once

// Statistics of matches and measurements. Pure functions and small values.

#include <cstdint>

namespace powderkeg {

// Both ends belong to it.
struct Interval {
  double low = 0;
  double high = 0;

  friend bool operator==(const Interval&, const Interval&) = default;
};

// The standard normal quantile of two-sided 95 % intervals.
inline constexpr double kNormal95 = 1.959963984540054;

// The interval of a probability of which `successes` in `trials` were seen (Wilson 1927);
// [0, 1] without trials. Requires successes <= trials.
[[nodiscard]] Interval WilsonInterval(std::uint64_t successes, std::uint64_t trials,
                                      double quantile = kNormal95);

// The same for the mean of a figure that lies in [0, 1] in every trial, such as points per game: as
// wide as if it were 0 or 1 every time, which is never too narrow. Requires a mean in [0, 1].
[[nodiscard]] Interval ScoreInterval(double mean, std::uint64_t trials,
                                     double quantile = kNormal95);

// Mean and spread of a stream of numbers (Welford 1962). A value.
class RunningStatistics {
 public:
  void Add(double sample);
  // As if the samples of `other` had been added too (Chan et al. 1979).
  RunningStatistics& operator+=(const RunningStatistics& other);

  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double mean() const { return mean_; }  // 0 without samples
  // Of the samples (divided by count - 1); 0 with fewer than two.
  [[nodiscard]] double variance() const;
  [[nodiscard]] double standard_deviation() const;
  // Normal interval of the mean: mean +- quantile * standard error.
  [[nodiscard]] Interval MeanInterval(double quantile = kNormal95) const;

 private:
  std::uint64_t count_ = 0;
  double mean_ = 0;
  double squares_ = 0;  // sum of squared distances from the mean
};

// A match as seen by one side.
struct MatchScore {
  std::uint64_t wins = 0;
  std::uint64_t ties = 0;
  std::uint64_t losses = 0;

  [[nodiscard]] std::uint64_t games() const { return wins + ties + losses; }

  // One more game: won if `outcome` is above 0, tied at 0, lost below.
  void Add(int outcome) { ++(outcome > 0 ? wins : outcome < 0 ? losses : ties); }
  MatchScore& operator+=(const MatchScore& other);
  friend bool operator==(const MatchScore&, const MatchScore&) = default;
};

// The Elo difference at which a side is expected to score `score` (0 to 1; infinite at the ends):
// 400 log10(score / (1 - score)).
[[nodiscard]] double EloFromScore(double score);
struct EloEstimate {
  double elo = 0;
  Interval interval;  // infinite ends where the interval of the score reaches 0 or 1
};

}  // namespace powderkeg

#include "common/base/stats.h"

#include <cmath>
#include <cstddef>
#include <limits>

#include "common/base/check.h"

namespace powderkeg {
namespace {

constexpr double kPrecision = 1e-15;
constexpr int kMaxTerms = 10'000;

// x^a e^-x / Gamma(a)
double GammaFactor(double a, double x) { return std::exp(a * std::log(x) - x - std::lgamma(a)); }

// The regularised lower incomplete gamma function by its power series; for x < a + 1.
double LowerGammaSeries(double a, double x) {
  double term = 1 / a;
  double sum = term;
  for (int n = 1; n < kMaxTerms && term > sum * kPrecision; ++n) {
    term *= x / (a + n);
    sum += term;
  }
  return sum * GammaFactor(a, x);
}

// The regularised upper incomplete gamma function by its continued fraction (Lentz); for
// x >= a + 1.
double UpperGammaFraction(double a, double x) {
  double b = x + 1 - a;
  double c = std::numeric_limits<double>::max();
  double d = 1 / b;
  double fraction = d;
  for (int n = 1; n < kMaxTerms; ++n) {
    const double numerator = -n * (n - a);
    b += 2;
    d = 1 / (numerator * d + b);
    c = b + numerator / c;
    fraction *= c * d;
    if (std::abs(c * d - 1) < kPrecision) break;
  }
  return fraction * GammaFactor(a, x);
}

}  // namespace

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

double MatchScore::score() const {
  CHECK(games() > 0);
  return (static_cast<double>(wins) + 0.5 * static_cast<double>(ties)) /
         static_cast<double>(games());
}

double MatchScore::variance() const {
  const double mean = score();
  const double squares = static_cast<double>(wins) + 0.25 * static_cast<double>(ties);
  return squares / static_cast<double>(games()) - mean * mean;
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

double ScoreFromElo(double elo) { return 1 / (1 + std::pow(10, -elo / 400)); }

EloEstimate EloDifference(const MatchScore& match, double quantile) {
  const double score = match.score();
  const double radius = quantile * std::sqrt(match.variance() / static_cast<double>(match.games()));
  return {EloFromScore(score), {EloFromScore(score - radius), EloFromScore(score + radius)}};
}

SprtResult Sprt(const MatchScore& match, const SprtSettings& settings) {
  SprtResult result;
  result.bounds = {std::log(settings.beta / (1 - settings.alpha)),
                   std::log((1 - settings.beta) / settings.alpha)};
  if (match.games() == 0 || match.variance() <= 0) return result;
  const double score0 = ScoreFromElo(settings.elo0);
  const double score1 = ScoreFromElo(settings.elo1);
  result.log_likelihood_ratio = static_cast<double>(match.games()) * (score1 - score0) *
                                (2 * match.score() - score0 - score1) / (2 * match.variance());
  if (result.log_likelihood_ratio <= result.bounds.low) result.verdict = SprtVerdict::kAcceptElo0;
  if (result.log_likelihood_ratio >= result.bounds.high) result.verdict = SprtVerdict::kAcceptElo1;
  return result;
}

double ChiSquared(std::span<const double> observed, std::span<const double> expected) {
  CHECK(observed.size() == expected.size(), observed.size(), " and ", expected.size());
  double sum = 0;
  for (std::size_t i = 0; i < observed.size(); ++i) {
    CHECK(expected[i] > 0, "class ", i);
    const double distance = observed[i] - expected[i];
    sum += distance * distance / expected[i];
  }
  return sum;
}

double ChiSquaredTail(double statistic, int degrees) {
  CHECK(degrees > 0, degrees);
  if (statistic <= 0) return 1;
  const double a = 0.5 * degrees;
  const double x = 0.5 * statistic;
  return x < a + 1 ? 1 - LowerGammaSeries(a, x) : UpperGammaFraction(a, x);
}

}  // namespace powderkeg

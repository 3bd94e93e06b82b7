#include "common/base/rating.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace powderkeg {
namespace {

const double kEloPerLogit = 400 / std::log(10.0);

constexpr int kRounds = 1000;  // at most
constexpr double kPrecise = 1e-9;
constexpr double kPriorGames = 1;  // tied, with a player of strength 1

double GamesOf(const PairScore& pair) { return static_cast<double>(pair.score.games()); }

double PointsOfFirst(const PairScore& pair) {
  return static_cast<double>(pair.score.wins) + 0.5 * static_cast<double>(pair.score.ties);
}

// The next strengths; the largest relative change.
double Improve(const std::vector<double>& points, std::span<const PairScore> pairs,
               std::vector<double>& strengths) {
  std::vector<double> weights(strengths.size());
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = kPriorGames / (strengths[i] + 1);
  for (const PairScore& pair : pairs) {
    const double weight = GamesOf(pair) / (strengths[pair.first] + strengths[pair.second]);
    weights[pair.first] += weight;
    weights[pair.second] += weight;
  }
  double change = 0;
  for (std::size_t i = 0; i < strengths.size(); ++i) {
    const double next = points[i] / weights[i];
    change = std::max(change, std::abs(next / strengths[i] - 1));
    strengths[i] = next;
  }
  return change;
}

}  // namespace

std::vector<Rating> RatePlayers(std::size_t players, std::span<const PairScore> pairs) {
  std::vector<double> points(players, kPriorGames / 2);
  std::vector<double> strengths(players, 1.0);
  for (const PairScore& pair : pairs) {
    points[pair.first] += PointsOfFirst(pair);
    points[pair.second] += GamesOf(pair) - PointsOfFirst(pair);
  }
  for (int round = 0; round < kRounds && Improve(points, pairs, strengths) > kPrecise; ++round) {
  }
  std::vector<double> information(players);
  for (const PairScore& pair : pairs) {
    const double p = strengths[pair.first] / (strengths[pair.first] + strengths[pair.second]);
    information[pair.first] += GamesOf(pair) * p * (1 - p);
    information[pair.second] += GamesOf(pair) * p * (1 - p);
  }
  std::vector<Rating> ratings(players);
  double mean = 0;
  for (const double strength : strengths) {
    mean += std::log(strength) / static_cast<double>(players);
  }
  for (std::size_t i = 0; i < players; ++i) {
    ratings[i].elo = kEloPerLogit * (std::log(strengths[i]) - mean);
    ratings[i].half_interval = kEloPerLogit * kNormal95 / std::sqrt(information[i]);
  }
  return ratings;
}

int Compare(const Place& first, const Place& second) {
  return first > second ? 1 : first < second ? -1 : 0;
}

std::vector<RatedName> RateNames(const NamedScores& pairs) {
  std::map<std::string, std::size_t> numbers;
  std::vector<RatedName> rated;
  const auto number_of = [&](const std::string& name) {
    const auto [entry, added] = numbers.emplace(name, rated.size());
    if (added) rated.push_back({.name = name, .rating = {}});
    return entry->second;
  };
  std::vector<PairScore> scores;
  for (const auto& [names, score] : pairs) {
    scores.push_back({number_of(names.first), number_of(names.second), score});
    for (const std::size_t one : {scores.back().first, scores.back().second}) {
      rated[one].games += score.games();
    }
  }
  const std::vector<Rating> ratings = RatePlayers(rated.size(), scores);
  for (std::size_t i = 0; i < rated.size(); ++i) rated[i].rating = ratings[i];
  std::ranges::sort(rated, std::greater(), [](const RatedName& r) { return r.rating.elo; });
  return rated;
}

}  // namespace powderkeg

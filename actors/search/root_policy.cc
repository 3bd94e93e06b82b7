#include "actors/search/root_policy.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "common/model/evaluator.h"

namespace powderkeg {
namespace {

using Scores = std::array<double, kActionCount>;

// Shares of the visits, mixed with the shares of the values (moved to [0, 1]) by q_weight.
Scores ScoresOf(const SearchSettings& settings, const RootStatistics& root) {
  Scores visits{};
  Scores values{};
  for (std::size_t a = 0; a < kActionCount; ++a) {
    if (root.visits[a] == 0) continue;
    visits[a] = root.visits[a];
    values[a] = std::max(0.0, (1.0 + static_cast<double>(root.values[a])) / 2);
  }
  const double all_visits = std::accumulate(visits.begin(), visits.end(), 0.0);
  const double all_values = std::accumulate(values.begin(), values.end(), 0.0);
  const double weight = all_values > 0 ? settings.q_weight : 0;
  Scores scores{};
  for (std::size_t a = 0; a < kActionCount; ++a) {
    scores[a] = (1 - weight) * visits[a] / all_visits;
    if (weight > 0) scores[a] += weight * values[a] / all_values;
  }
  return scores;
}

std::size_t Draw(const Scores& scores, double temperature, Rng& rng) {
  const double highest = *std::ranges::max_element(scores);
  Scores weights{};
  for (std::size_t a = 0; a < kActionCount; ++a) {
    if (scores[a] > 0) weights[a] = std::pow(scores[a] / highest, 1 / temperature);
  }
  double remaining = rng.Uniform() * std::accumulate(weights.begin(), weights.end(), 0.0);
  for (std::size_t a = 0; a < kActionCount; ++a) {
    remaining -= weights[a];
    if (weights[a] > 0 && remaining < 0) return a;
  }
  return static_cast<std::size_t>(std::ranges::max_element(scores) - scores.begin());
}

std::size_t MostPromising(const Scores& scores, const RootStatistics& root) {
  std::size_t best = 0;
  for (std::size_t a = 1; a < kActionCount; ++a) {
    if (scores[a] > scores[best] ||
        (scores[a] > 0 && scores[a] == scores[best] && root.values[a] > root.values[best])) {
      best = a;
    }
  }
  return best;
}

// The most valuable visited action.
std::size_t MostValuable(const RootStatistics& root, std::size_t at_least) {
  std::size_t best = at_least;
  for (std::size_t a = 0; a < kActionCount; ++a) {
    if (root.visits[a] > 0 && root.values[a] > root.values[best]) best = a;
  }
  return best;
}

// k P N, the square of the visits that are forced.
double ForcedVisitsSquared(double k, const RootStatistics& root, std::size_t action) {
  const double all = std::accumulate(root.visits.begin(), root.visits.end(), 0.0);
  return k * static_cast<double>(root.priors[action]) * all;
}

}  // namespace

std::array<float, kActionCount> WithNoise(const SearchSettings& settings,
                                          std::span<const float, kActionCount> priors,
                                          ActionSet legal, Rng& rng) {
  Scores noise{};
  double total = 0;
  for (std::size_t a = 0; a < kActionCount; ++a) {
    if (Has(legal, a)) total += noise[a] = rng.Gamma(settings.noise_alpha);
  }
  std::array<float, kActionCount> mixed{};
  for (std::size_t a = 0; a < kActionCount; ++a) {
    if (!Has(legal, a)) continue;
    const double share = total > 0 ? noise[a] / total : 0;
    mixed[a] = static_cast<float>((1 - settings.noise_weight) * static_cast<double>(priors[a]) +
                                  settings.noise_weight * share);
  }
  return mixed;
}

Action ChooseMove(const SearchSettings& settings, const RootStatistics& root, Rng rng) {
  if (std::ranges::all_of(root.visits, [](std::uint32_t visits) { return visits == 0; })) {
    return BestAction(root.priors, root.legal);
  }
  const Scores scores = ScoresOf(settings, root);
  std::size_t chosen = settings.temperature > 0 ? Draw(scores, settings.temperature, rng)
                                                : MostPromising(scores, root);
  if (settings.q_veto > 0) {
    const std::size_t valuable = MostValuable(root, chosen);
    const auto lead = static_cast<double>(root.values[valuable] - root.values[chosen]);
    if (lead > settings.q_veto) chosen = valuable;
  }
  return static_cast<Action>(chosen);
}

std::size_t ForcedAction(double k, const RootStatistics& root) {
  for (std::size_t a = 0; a < kActionCount; ++a) {
    const double visits = root.visits[a];
    if (visits > 0 && visits * visits < ForcedVisitsSquared(k, root, a)) return a;
  }
  return kActionCount;
}

std::array<std::uint32_t, kActionCount> WithoutForced(double k, double exploration,
                                                      const RootStatistics& root) {
  const auto score = [&](std::size_t a, std::uint32_t visits) {
    return static_cast<double>(root.values[a]) +
           exploration * static_cast<double>(root.priors[a]) / (1.0 + visits);
  };
  const auto best = static_cast<std::size_t>(ChooseMove({}, root, Rng(0)));
  std::array<std::uint32_t, kActionCount> visits = root.visits;
  for (std::size_t a = 0; a < kActionCount; ++a) {
    if (a == best) continue;
    auto forced = static_cast<std::uint32_t>(std::sqrt(ForcedVisitsSquared(k, root, a)));
    for (; forced > 0 && visits[a] > 0; --forced) {
      if (score(a, visits[a] - 1) >= score(best, visits[best])) break;
      --visits[a];
    }
    if (visits[a] == 1) visits[a] = 0;
  }
  return visits;
}

}  // namespace powderkeg

#include "actors/search/gumbel_root.h"

#include <algorithm>
#include <bit>
#include <initializer_list>
#include <limits>
#include <span>

#include "actors/search/portable_math.h"

namespace powderkeg {
namespace {

using Scores = std::array<double, kActionCount>;

double LogPrior(const RootStatistics& root, std::size_t action) {
  constexpr double kSmallest = 1e-9;
  return Log(std::max(static_cast<double>(root.priors[action]), kSmallest));
}

double GumbelNumber(Rng& rng) {
  const double uniform = std::max(rng.Uniform(), 0x1.0p-54);
  return -Log(-Log(uniform));
}

double MixedValue(const RootStatistics& root) {
  double visits = 0;
  double priors = 0;
  double weighted = 0;
  for (std::size_t a = 0; a < kActionCount; ++a) {
    if (root.visits[a] == 0 || !Has(root.legal, a)) continue;
    const double prior = std::max(static_cast<double>(root.priors[a]), 1e-9);
    visits += root.visits[a];
    priors += prior;
    weighted += prior * static_cast<double>(root.values[a]);
  }
  const auto evaluation = static_cast<double>(root.evaluation);
  return visits == 0 ? evaluation : (evaluation + visits * weighted / priors) / (1 + visits);
}

// The legal ones of the first set that has any; else all that are legal.
ActionSet StillLegal(std::initializer_list<ActionSet> sets, const RootStatistics& root) {
  for (const ActionSet actions : sets) {
    if ((actions & root.legal) != 0) return static_cast<ActionSet>(actions & root.legal);
  }
  return root.legal;
}

// sigma of the completed values.
Scores TransformedValues(const RootStatistics& root, double c_visit, double c_scale) {
  const double most_visits = *std::ranges::max_element(root.visits);
  const double scale = (c_visit + most_visits) * c_scale;
  const double mixed = MixedValue(root);
  Scores transformed;
  for (std::size_t a = 0; a < kActionCount; ++a) {
    const double value = root.visits[a] > 0 ? static_cast<double>(root.values[a]) : mixed;
    transformed[a] = scale * (value + 1) / 2;
  }
  return transformed;
}

}  // namespace

std::array<double, kActionCount> ImprovedPolicy(const SearchSettings& settings,
                                                const RootStatistics& root) {
  Scores logits = TransformedValues(root, settings.gumbel_c_visit, settings.gumbel_c_scale);
  double highest = -std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < kActionCount; ++a) {
    logits[a] += LogPrior(root, a);
    if (Has(root.legal, a)) highest = std::max(highest, logits[a]);
  }
  Scores policy{};
  double total = 0;
  for (std::size_t a = 0; a < kActionCount; ++a) {
    if (Has(root.legal, a)) total += policy[a] = ExpOfNegative(logits[a] - highest);
  }
  for (double& share : policy) share /= total;
  return policy;
}

void SequentialHalving::Start(const SearchSettings& settings, const RootStatistics& root,
                              Rng& rng) {
  c_visit_ = settings.gumbel_c_visit;
  c_scale_ = settings.gumbel_c_scale;
  repeats_ = settings.gumbel_first_halving > 0;
  simulations_ = repeats_ ? std::min(settings.gumbel_first_halving, settings.simulations)
                          : settings.simulations;
  for (std::size_t a = 0; a < kActionCount; ++a) {
    urges_[a] = LogPrior(root, a);
    if (settings.gumbel_scale > 0) urges_[a] += settings.gumbel_scale * GumbelNumber(rng);
  }
  Consider(root.legal, urges_, std::min(settings.gumbel_considered, settings.simulations));
  candidates_ = leaders_ = considered_;
  BeginHalving();
}

Action SequentialHalving::Next(const RootStatistics& root) {
  if ((considered_ & ~root.legal) != 0) {
    LeaveOutLost(root);
  } else if (phase_is_over()) {
    EndPhase(root);
  }
  return static_cast<Action>(order_[static_cast<std::size_t>(next_++ % count_)]);
}

void SequentialHalving::LeaveOutLost(const RootStatistics& root) {
  Consider(StillLegal({considered_}, root), ScoresOf(root), kActionCount);
  BeginPhase();
}

void SequentialHalving::EndPhase(const RootStatistics& root) {
  if (repeats_ && count_ <= 2) {
    simulations_ *= 2;
    Consider(StillLegal({candidates_}, root), ScoresOf(root), kActionCount);
    BeginHalving();
    return;
  }
  Consider(considered_, ScoresOf(root), std::max(2, count_ / 2));
  leaders_ = considered_;
  BeginPhase();
}

Action SequentialHalving::Best(const RootStatistics& root) const {
  ActionSet candidates = StillLegal({leaders_, considered_}, root);
  ActionSet visited = 0;
  for (std::size_t a = 0; a < kActionCount; ++a) {
    if (Has(candidates, a) && root.visits[a] > 0) visited |= static_cast<ActionSet>(1U << a);
  }
  if (visited != 0) candidates = visited;
  const Scores scores = ScoresOf(root);
  auto best = static_cast<std::size_t>(std::countr_zero(candidates));
  for (std::size_t a = best + 1; a < kActionCount; ++a) {
    if (Has(candidates, a) && scores[a] > scores[best]) best = a;
  }
  return static_cast<Action>(best);
}

SequentialHalving::Scores SequentialHalving::ScoresOf(const RootStatistics& root) const {
  Scores scores = TransformedValues(root, c_visit_, c_scale_);
  for (std::size_t a = 0; a < kActionCount; ++a) scores[a] += urges_[a];
  return scores;
}

// Keeps the `most` best of the actions; equal ones by number.
void SequentialHalving::Consider(ActionSet actions, const Scores& scores, int most) {
  count_ = 0;
  for (std::size_t a = 0; a < kActionCount; ++a) {
    if (Has(actions, a)) order_[static_cast<std::size_t>(count_++)] = a;
  }
  std::ranges::sort(std::span(order_).first(static_cast<std::size_t>(count_)),
                    [&](std::size_t a, std::size_t b) {
                      return scores[a] != scores[b] ? scores[a] > scores[b] : a < b;
                    });
  count_ = std::min(count_, most);
  considered_ = 0;
  for (int i = 0; i < count_; ++i) {
    considered_ |= static_cast<ActionSet>(1U << order_[static_cast<std::size_t>(i)]);
  }
}

void SequentialHalving::BeginHalving() {
  phases_ = std::max(1, static_cast<int>(std::bit_width(static_cast<unsigned>(count_ - 1))));
  BeginPhase();
}

// All phases of a halving have about as many simulations: simulations / ceil(log2 of the actions
// considered at first). What is left after the last one goes to the last two actions.
void SequentialHalving::BeginPhase() {
  next_ = 0;
  phase_end_ = count_ * std::max(1, simulations_ / (phases_ * count_));
}

}  // namespace powderkeg

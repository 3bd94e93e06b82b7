#pragma once

// The root of Gumbel AlphaZero: Danihelka, Guez, Schrittwieser, Silver, "Policy improvement by
// planning with Gumbel" (ICLR 2022). Inside the tree selection stays PUCT.
//
// sigma(q) = (c_visit + largest visit count) c_scale (q + 1) / 2, as values are in [-1, 1].
// The completed value of an action is its mean value; without a visit, the mixed value
// v_mix = (v + N sum P q / sum P) / (1 + N), sums over visited actions, v the evaluator's value.
//
// Sequential halving has to know how many simulations there will be. Under a clock nobody does:
// then one halving follows another, each of twice as many simulations as the one before
// (gumbel_first_halving), all with the same Gumbel numbers and with the values found so far. After
// the first one, whenever the clock ends the search, at most a third of its simulations (a quarter
// with five or six actions) were spread evenly by a halving that has not chosen yet; the others lie
// as in a search of known length. (Sagers, Winands, Soemers 2024, "Anytime sequential halving in
// Monte-Carlo tree search", make all halvings as short as can be; as every choice waits for all
// answers, that would leave batches of several leaves half empty.)

#include <array>

#include "actors/search/root_policy.h"
#include "common/base/rng.h"
#include "common/config/search_settings.h"

namespace powderkeg {

// pi' = softmax(ln P + sigma(completed values)) over root.legal, 0 elsewhere: better than P
// wherever the values are right, whatever was visited. The policy to learn from.
[[nodiscard]] std::array<double, kActionCount> ImprovedPolicy(const SearchSettings& settings,
                                                              const RootStatistics& root);

// Shares the simulations of one search out among the actions by sequential halving. Considers the
// actions with the highest g + ln P, g a Gumbel number each; visits all of them equally often;
// keeps the better half by g + ln P + sigma(q); and so on down to two, which get what is left, or
// after which the next halving begins with all of them. Visits of a kept tree count in the values,
// not in the shares. A value; one thread.
class SequentialHalving {
 public:
  // Begins a search of settings.simulations.
  void Start(const SearchSettings& settings, const RootStatistics& root, Rng& rng);

  // Whether Next chooses by values: then all earlier simulations should have ended.
  [[nodiscard]] bool phase_is_over() const { return next_ == phase_end_; }

  // What the next simulation starts with: an action of root.legal, which may have lost some since
  // Start but not all.
  Action Next(const RootStatistics& root);
  // The last simulation was not made after all.
  void TakeBack() { --next_; }

  // The best one of those that the last choice by values has left (of the visited ones, if there
  // are any).
  [[nodiscard]] Action Best(const RootStatistics& root) const;

 private:
  using Scores = std::array<double, kActionCount>;

  [[nodiscard]] Scores ScoresOf(const RootStatistics& root) const;
  void LeaveOutLost(const RootStatistics& root);
  void EndPhase(const RootStatistics& root);
  void Consider(ActionSet actions, const Scores& scores, int most);
  void BeginHalving();
  void BeginPhase();

  double c_visit_ = 0;
  double c_scale_ = 0;
  bool repeats_ = false;
  int simulations_ = 0;       // of this halving
  int phases_ = 1;            // of it
  Scores urges_{};            // g + ln P
  ActionSet candidates_ = 0;  // considered at first
  ActionSet considered_ = 0;
  ActionSet leaders_ = 0;                          // what the last choice by values left
  std::array<std::size_t, kActionCount> order_{};  // the considered ones, best first
  int count_ = 0;
  int next_ = 0;  // simulations of this phase
  int phase_end_ = 0;
};

}  // namespace powderkeg

#include "learner/train/schedule.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/base/check.h"

namespace powderkeg {
namespace {

// Of a game before the first one was added.
constexpr std::uint64_t kUsualDecisions = 200;

// One cycle (Smith and Topin 2018) rises from 1 / kRiseFactor in this part of the run.
constexpr double kRise = 0.3;
constexpr double kRiseFactor = 25;

// Half a cosine from one value to the other; `part` from 0 to 1.
double AlongCosine(double from, double to, double part) {
  return to + (from - to) * (1 + std::cos(std::numbers::pi * part)) / 2;
}

}  // namespace

double LearningRateAfter(const TrainingConfig& training, double iterations) {
  const double highest = training.learning_rate;
  const double last = training.final_learning_rate;
  const double part = iterations / training.iterations;
  if (training.learning_rate_schedule == "cosine") return AlongCosine(highest, last, part);
  if (training.learning_rate_schedule == "one_cycle") {
    if (part < kRise) return AlongCosine(highest / kRiseFactor, highest, part / kRise);
    return AlongCosine(highest, last, (part - kRise) / (1 - kRise));
  }
  return last == 0 ? highest : highest * std::pow(last / highest, part);
}

std::uint32_t VersionToPlay(int iterations_done, FirstWeights first) {
  if (iterations_done == 0 && first == FirstWeights::kUntrained) return 0;
  return static_cast<std::uint32_t>(iterations_done) + 1;
}

Schedule::Schedule(const ScheduleSettings& settings, std::vector<TicketRange> data_sets)
    : settings_(settings),
      data_sets_(std::move(data_sets)),
      prefix_(data_sets_.empty() ? 0 : data_sets_.back().last + 1) {
  CHECK(settings.iterations > 0 && settings.decisions_per_iteration > 0 &&
        settings.window_data_sets > 0 && settings.data_sets_ahead > 0);
}

Schedule::Use Schedule::Add(std::uint64_t ticket, std::uint32_t decisions) {
  const Use use = UseOf(ticket);
  ++games_added_;
  decisions_added_ += decisions;
  if (use != Use::kNextDataSets) return use;
  return prefix_.Add(ticket, decisions) ? use : Use::kNone;
}

void Schedule::CloseFirstDataSet() {
  games_added_ = decisions_added_ = 0;
  if (!data_sets_.empty()) return;
  const TicketPrefix::Progress games = prefix_.progress();
  CHECK(games.decisions > 0 && !games.straggler);
  closed_games_ = games.games;
  closed_decisions_ = games.decisions;
}

Schedule::Use Schedule::UseOf(std::uint64_t ticket) const {
  if (ticket >= prefix_.next_ticket()) return Use::kNextDataSets;
  const bool in_window = std::ranges::any_of(
      WindowOfNext(), [&](const TicketRange& range) { return range.Has(ticket); });
  return in_window ? Use::kWindow : Use::kNone;
}

std::uint64_t Schedule::OldestTicketNeeded(int checkpoints) const {
  const auto sets = static_cast<std::size_t>(settings_.window_data_sets - 1 + checkpoints - 1);
  if (sets >= data_sets_.size()) return 0;
  return sets == 0 ? next_ticket() : data_sets_[data_sets_.size() - sets].first;
}

int Schedule::IterationOf(std::uint64_t ticket) const {
  const auto of =
      std::ranges::find_if(data_sets_, [&](const TicketRange& range) { return range.Has(ticket); });
  return static_cast<int>(of - data_sets_.begin()) + 1;
}

std::uint64_t Schedule::GamesWanted() const {
  const int data_sets = std::min(settings_.data_sets_ahead, settings_.iterations - iteration());
  const std::uint64_t wanted =
      static_cast<std::uint64_t>(data_sets) * settings_.decisions_per_iteration;
  const std::uint64_t there = prefix_.progress().decisions;
  if (there >= wanted) return 0;
  const std::uint64_t mean =
      decisions_added_ == 0 ? kUsualDecisions : (decisions_added_ - 1) / games_added_ + 1;
  return (wanted - there - 1) / mean + 1;
}

std::optional<TicketRange> Schedule::StartIteration() {
  if (finished()) return std::nullopt;
  const std::uint64_t there = prefix_.progress().decisions_in_prefix;
  const std::uint64_t least = decisions_wanted();
  const auto range = prefix_.NextDataSet(settings_.growing ? std::max(least, there) : least);
  if (range) data_sets_.push_back(*range);
  return range;
}

std::span<const TicketRange> Schedule::WindowOfNext() const {
  const auto window = static_cast<std::size_t>(settings_.window_data_sets);
  const std::size_t count = std::min(window - 1, data_sets_.size());
  return std::span(data_sets_).last(count);
}

}  // namespace powderkeg

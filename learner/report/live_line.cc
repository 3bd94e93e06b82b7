#include "learner/report/live_line.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

namespace powderkeg {
namespace {

// Weight of the newest interval in a rate: about the last ten calls count.
constexpr double kNewest = 0.15;
constexpr int kBarWidth = 16;

void Average(double& rate, double newest) {
  rate = rate == 0 ? newest : (1 - kNewest) * rate + kNewest * newest;
}

// A counter that went back (an actor started anew) counts from 0.
double Increase(std::uint64_t before, std::uint64_t after) {
  return static_cast<double>(after >= before ? after - before : after);
}

std::string Short(double number) {
  char text[32];
  if (number >= 1e6) {
    std::snprintf(text, sizeof text, "%.1f M", number / 1e6);
  } else if (number >= 1e4) {
    std::snprintf(text, sizeof text, "%.1f k", number / 1e3);
  } else {
    std::snprintf(text, sizeof text, number < 100 ? "%.1f" : "%.0f", number);
  }
  return text;
}

double Share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

std::string Bar(double share) {
  const int full = static_cast<int>(std::lround(std::clamp(share, 0.0, 1.0) * kBarWidth));
  return "[" + std::string(static_cast<std::size_t>(full), '#') +
         std::string(static_cast<std::size_t>(kBarWidth - full), '.') + "]";
}

std::string TimeLeft(double amount, double per_s) {
  if (per_s <= 0 || amount < 0) return "";
  const long seconds = std::lround(amount / per_s);
  if (seconds < 120) return ", " + std::to_string(seconds) + " s left";
  return ", " + std::to_string(seconds / 60) + " min left";
}

std::string BarOf(const LiveStatus& status) {
  return Bar(status.samples_wanted > 0 ? Share(status.samples, status.samples_wanted)
                                       : Share(status.decisions, status.decisions_wanted));
}

}  // namespace

std::string Grouped(std::uint64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t place = text.size(); place > 3;) {
    place -= 3;
    text.insert(place, ",");
  }
  return text;
}

std::string LiveLine::Next(const LiveStatus& status, Clock::time_point now, std::size_t width) {
  Measure(status, now);
  const std::string head =
      "iteration " + std::to_string(status.iteration()) + "/" + std::to_string(status.iterations);
  const std::string activity = Activity(status);
  std::string line = head + " " + BarOf(status) + activity;
  if (line.size() > width) line = head + activity;
  std::vector<std::string> items = {std::to_string(status.actors) +
                                    (status.actors == 1 ? " actor" : " actors")};
  if (decisions_per_s_ > 0) items.push_back(Short(decisions_per_s_) + " decisions/s");
  if (games_per_s_ > 0) items.push_back(Short(games_per_s_) + " games/s");
  if (evaluations_per_s_ > 0) items.push_back(Short(evaluations_per_s_) + " evaluations/s");
  if (mean_batch_ > 0) items.push_back("batch " + Short(mean_batch_));
  std::string separator = " | ";
  for (const std::string& item : items) {
    if (line.size() + separator.size() + item.size() > width) break;
    line += std::exchange(separator, ", ") + item;
  }
  return line.substr(0, width);
}

// What it waits for or does, with a space before it.
std::string LiveLine::Activity(const LiveStatus& status) const {
  const std::string have = " have " + Grouped(status.decisions) + " of " +
                           Grouped(status.decisions_wanted) + " decisions";
  switch (PhaseOf(status)) {
    case Phase::kComplete: return " done";
    case Phase::kPreparing: return " has its games";
    case Phase::kTraining:
      return " training " + Grouped(status.samples) + " of " + Grouped(status.samples_wanted) +
             " samples, " + Short(samples_per_s_) + "/s" +
             TimeLeft(static_cast<double>(status.samples_wanted - status.samples), samples_per_s_);
    case Phase::kWaitingForActors: return have + ", waiting for actors";
    case Phase::kWaitingForGame:
      return have + ", waiting for game " + std::to_string(*status.straggler);
    case Phase::kPlaying: break;
  }
  const std::uint64_t finished = status.decisions + status.decisions_beyond;
  return have +
         TimeLeft(static_cast<double>(status.decisions_wanted) - static_cast<double>(finished),
                  decisions_per_s_);
}

void LiveLine::Measure(const LiveStatus& status, Clock::time_point now) {
  if (last_) {
    const double seconds = std::chrono::duration<double>(now - last_->time).count();
    if (seconds <= 0) return;
    const LiveTotals& before = last_->totals;
    const LiveTotals& after = status.totals;
    const double evaluations = Increase(before.evaluations, after.evaluations);
    const double batches = Increase(before.batches, after.batches);
    Average(games_per_s_, Increase(before.games, after.games) / seconds);
    Average(decisions_per_s_, Increase(before.decisions, after.decisions) / seconds);
    Average(evaluations_per_s_, evaluations / seconds);
    if (batches > 0) Average(mean_batch_, evaluations / batches);
    if (status.samples > last_->samples) {
      Average(samples_per_s_, static_cast<double>(status.samples - last_->samples) / seconds);
    }
  }
  last_ = {now, status.totals, status.samples};
}

}  // namespace powderkeg

#include "learner/report/live_line.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

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

double Share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
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

std::string LiveLine::Next(const LiveStatus& status, Clock::time_point now) {
  Measure(status, now);
  std::string line =
      "iteration " + std::to_string(status.iteration) + "/" + std::to_string(status.iterations);
  if (status.samples_wanted > 0) {
    line += " " + Bar(Share(status.samples, status.samples_wanted)) + " training " +
            Grouped(status.samples) + " of " + Grouped(status.samples_wanted) + " samples, " +
            Short(samples_per_s_) + "/s" +
            TimeLeft(static_cast<double>(status.samples_wanted - status.samples), samples_per_s_);
  } else if (status.decisions >= status.decisions_wanted) {
    line += " has its games";
  } else {
    line += " " + Bar(Share(status.decisions, status.decisions_wanted)) + " have " +
            Grouped(status.decisions) + " of " + Grouped(status.decisions_wanted) + " decisions";
    const bool enough_behind =
        status.decisions + status.decisions_beyond >= status.decisions_wanted;
    if (status.straggler && enough_behind) {
      line += ", waiting for game " + std::to_string(*status.straggler);
    } else {
      line += TimeLeft(
          static_cast<double>(status.decisions_wanted - status.decisions - status.decisions_beyond),
          decisions_per_s_);
    }
  }
  return line + " | " + Short(games_per_s_) + " games/s, " + Short(decisions_per_s_) +
         " decisions/s, " + Short(evaluations_per_s_) + " evaluations/s, batch " +
         Short(mean_batch_) + " | " + std::to_string(status.actors) +
         (status.actors == 1 ? " actor" : " actors");
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

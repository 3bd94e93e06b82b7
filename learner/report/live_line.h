#pragma once

// The line that shows on a terminal what a run is doing right now.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "learner/report/live_status.h"

namespace powderkeg {

// Turns successive statuses into lines with rates over the last seconds. One thread.
class LiveLine {
 public:
  using Clock = std::chrono::steady_clock;

  // The line without its end, at most `width` characters: what does not fit is left out, the least
  // important first. For instance:
  //   iteration 3/40 [######......] have 12,412 of 25,000 decisions, 33 s left | 480 decisions/s,
  //   ...
  [[nodiscard]] std::string Next(const LiveStatus& status, Clock::time_point now,
                                 std::size_t width = std::string::npos);

 private:
  struct Moment {
    Clock::time_point time;
    LiveTotals totals;
    std::uint64_t samples = 0;
  };
  [[nodiscard]] std::string Activity(const LiveStatus& status) const;
  void Measure(const LiveStatus& status, Clock::time_point now);

  std::optional<Moment> last_;
  double games_per_s_ = 0;
  double decisions_per_s_ = 0;
  double evaluations_per_s_ = 0;
  double samples_per_s_ = 0;
  double mean_batch_ = 0;
};

// 61212 -> "61,212".
[[nodiscard]] std::string Grouped(std::uint64_t number);

}  // namespace powderkeg

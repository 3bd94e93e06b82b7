#pragma once

// The line that shows on a terminal what a run is doing right now.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace powderkeg {

// Totals at one moment, all since the start of the learner or of the actors.
struct LiveTotals {
  std::uint64_t games = 0;      // durable
  std::uint64_t decisions = 0;  // in those
  std::uint64_t evaluations = 0;
  std::uint64_t batches = 0;
};

// What the run is at.
struct LiveStatus {
  int iteration = 0;  // in progress, from 1
  int iterations = 0;
  std::uint64_t decisions = 0;         // usable for the iteration's data set
  std::uint64_t decisions_wanted = 0;  // in it
  std::uint64_t decisions_beyond = 0;  // finished games behind a straggler
  std::optional<std::uint64_t> straggler;
  std::uint64_t samples = 0;  // trained; samples_wanted == 0: not training
  std::uint64_t samples_wanted = 0;
  std::size_t actors = 0;
  LiveTotals totals;
};

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

#pragma once

// What a run is doing right now.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace powderkeg {

// Totals at one moment, all since the start of the learner or of the actors.
struct LiveTotals {
  std::uint64_t games = 0;      // durable
  std::uint64_t decisions = 0;  // in those
  std::uint64_t evaluations = 0;
  std::uint64_t batches = 0;
};

struct LiveStatus {
  int iterations_done = 0;
  int iterations = 0;
  std::uint64_t decisions = 0;         // usable for the iteration's data set
  std::uint64_t decisions_wanted = 0;  // in it
  std::uint64_t decisions_beyond = 0;  // finished games behind a straggler
  std::optional<std::uint64_t> straggler{};
  std::uint64_t samples = 0;  // trained; samples_wanted == 0: not training
  std::uint64_t samples_wanted = 0;
  std::size_t actors = 0;
  LiveTotals totals{};

  // In progress, from 1; when all are done the last one.
  [[nodiscard]] int iteration() const { return std::min(iterations_done + 1, iterations); }
};

enum class Phase : std::uint8_t {
  kPlaying,           // the data set grows
  kWaitingForActors,  // there are none
  kWaitingForGame,    // for the straggler: all other games of the data set are there
  kPreparing,         // the data set is complete, the training begins
  kTraining,
  kComplete,
};
[[nodiscard]] Phase PhaseOf(const LiveStatus& status);

}  // namespace powderkeg

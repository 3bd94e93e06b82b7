#pragma once

// What the loops of an actor are doing, for its heartbeats.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "actors/play/game_loop.h"
#include "common/wire/messages.h"

namespace powderkeg {

// One loop at one moment.
struct LoopProgress {
  LoopMetrics metrics;
  int games_running = 0;
  std::uint64_t oldest_ticket = 0;                     // lowest in play
  std::chrono::steady_clock::time_point oldest_start;  // of that game
  std::uint32_t weights_version = 0;                   // for new games
};

// Thread-safe.
class Progress {
 public:
  explicit Progress(std::size_t loops) : loops_(loops) {}

  void Set(std::size_t loop, const LoopProgress& progress);
  // The loops end and start anew: what they counted is kept.
  void StartAnew();

  // The loops together; the outbox and the tickets are not filled in.
  [[nodiscard]] Heartbeat Sum(std::chrono::steady_clock::time_point now) const;

 private:
  mutable std::mutex mutex_;  // guards these
  LoopMetrics before_;        // of loops that have ended
  std::vector<LoopProgress> loops_;
};

}  // namespace powderkeg

#include "actors/selfplay/progress.h"

#include <algorithm>

namespace powderkeg {

void Progress::Set(std::size_t loop, const LoopProgress& progress) {
  const std::lock_guard lock(mutex_);
  loops_[loop] = progress;
}

void Progress::StartAnew() {
  const std::lock_guard lock(mutex_);
  for (LoopProgress& loop : loops_) {
    before_ += loop.metrics;
    loop = {};
  }
}

Heartbeat Progress::Sum(std::chrono::steady_clock::time_point now) const {
  const std::lock_guard lock(mutex_);
  LoopMetrics sum = before_;
  Heartbeat heartbeat;
  const auto slowest = std::ranges::min_element(loops_, {}, &LoopProgress::weights_version);
  if (slowest != loops_.end()) heartbeat.weights_version = slowest->weights_version;
  const LoopProgress* oldest = nullptr;
  for (const LoopProgress& loop : loops_) {
    sum += loop.metrics;
    heartbeat.games_running += static_cast<std::uint32_t>(loop.games_running);
    if (loop.games_running == 0) continue;
    if (oldest == nullptr || loop.oldest_ticket < oldest->oldest_ticket) oldest = &loop;
  }
  if (oldest != nullptr) {
    heartbeat.oldest_ticket = oldest->oldest_ticket;
    heartbeat.oldest_game =
        std::chrono::duration_cast<std::chrono::milliseconds>(now - oldest->oldest_start);
  }
  heartbeat.games = sum.games;
  heartbeat.steps = sum.steps;
  heartbeat.decisions = sum.decisions;
  heartbeat.simulations = sum.simulations;
  heartbeat.evaluations = sum.evaluations;
  heartbeat.batches = sum.batches;
  return heartbeat;
}

}  // namespace powderkeg

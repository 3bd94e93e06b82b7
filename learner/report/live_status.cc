#include "learner/report/live_status.h"

namespace powderkeg {

Phase PhaseOf(const LiveStatus& status) {
  if (status.iterations_done >= status.iterations) return Phase::kComplete;
  if (status.samples_wanted > 0) return Phase::kTraining;
  if (status.decisions >= status.decisions_wanted) return Phase::kPreparing;
  if (status.actors == 0) return Phase::kWaitingForActors;
  const std::uint64_t finished = status.decisions + status.decisions_beyond;
  const bool rest_is_there = finished >= status.decisions_wanted;
  return status.straggler && rest_is_there ? Phase::kWaitingForGame : Phase::kPlaying;
}

}  // namespace powderkeg

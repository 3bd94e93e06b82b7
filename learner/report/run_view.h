#pragma once

// What a run looks like from outside, at one moment.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "learner/intake/session_server.h"
#include "learner/report/live_status.h"

namespace powderkeg {

struct RunView {
  std::string run{};                // its name
  std::int64_t started_unix_s = 0;  // the learner
  LiveStatus status{};
  IntakeStatistics intake{};
  std::optional<std::vector<double>> last_iteration{};  // of IterationFigures()
};

}  // namespace powderkeg

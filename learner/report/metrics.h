#pragma once

// A run as metrics for a time series database.

#include <string>

#include "learner/report/run_view.h"

namespace powderkeg {

// The text that Prometheus scrapes.
inline constexpr const char* kMetricsType = "text/plain; version=0.0.4; charset=utf-8";

// Every figure with its HELP and TYPE in text format 0.0.4: powderkeg_run_..., powderkeg_... of the
// intake, powderkeg_actor_... and, of the last iteration, powderkeg_iteration_.... Counters begin
// at 0 when the learner starts, those of an actor when the actor does. What is not known yet is
// left out: there are no metrics of the last iteration before the first one has ended.
[[nodiscard]] std::string MetricsText(const RunView& view);

}  // namespace powderkeg

#pragma once

// A finished iteration as a line of text. What a report lacks has no column.

#include <cstddef>
#include <string>

#include "learner/train/iteration_report.h"

namespace powderkeg {

// The head of the table and a line of it, columns aligned, without line ends: as many of the first
// columns as fit into `width` characters. Shares are in percent, with 95 % Wilson intervals.
[[nodiscard]] std::string TableHeader(const IterationReport& report,
                                      std::size_t width = std::string::npos);
[[nodiscard]] std::string TableLine(const IterationReport& report,
                                    std::size_t width = std::string::npos);

// For the log.
[[nodiscard]] std::string LogLine(const IterationReport& report);

}  // namespace powderkeg

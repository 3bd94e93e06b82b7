#pragma once

// What is shown on standard output while a run goes on.

#include <cstddef>
#include <string>

#include "learner/report/live_line.h"
#include "learner/train/iteration_report.h"

namespace powderkeg {

// On a terminal a live line that is renewed in place, elsewhere a plain one every 15 s; and the
// table of iterations. One call at a time.
class Display {
 public:
  Display();

  void ShowStatus(const LiveStatus& status);
  void ShowLine(const std::string& line);
  void ShowIteration(const IterationReport& report);
  // Takes the live line away.
  void Clear();

 private:
  [[nodiscard]] std::size_t Width() const;

  const bool terminal_;
  LiveLine live_;
  LiveLine::Clock::time_point last_plain_;
  int lines_ = 0;
  std::string header_;  // of the table, as it was last shown
};

}  // namespace powderkeg

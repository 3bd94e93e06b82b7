#pragma once

// The clock of the benches.

#include <ctime>

namespace powderkeg {

// Processor time of the calling thread, in seconds.
inline double ThreadCpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace powderkeg

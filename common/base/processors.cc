#include "common/base/processors.h"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <thread>

namespace powderkeg {
namespace {

namespace fs = std::filesystem;

// Those that the calling thread may run on; all where the system has more than the mask holds.
int OwnProcessors() {
  cpu_set_t own;
  if (sched_getaffinity(0, sizeof own, &own) == 0) return CPU_COUNT(&own);
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

// "QUOTA PERIOD" in microseconds, or "max PERIOD", which leaves it at `processors`.
int WithinQuota(const fs::path& file, int processors) {
  double quota = 0;
  double period = 0;
  std::ifstream input(file);
  if (!(input >> quota >> period) || quota <= 0 || period <= 0) return processors;
  return static_cast<int>(std::clamp<double>(std::ceil(quota / period), 1, processors));
}

// Of this process, in the one hierarchy of cgroup v2: "0::/its/path".
fs::path OwnGroup(const fs::path& file) {
  std::ifstream input(file);
  for (std::string line; std::getline(input, line);) {
    if (line.starts_with("0::/")) return fs::path(line.substr(4));
  }
  return {};
}

}  // namespace

int UsableProcessors(const fs::path& groups, const fs::path& own) {
  int processors = OwnProcessors();
  fs::path group = groups;
  processors = WithinQuota(group / "cpu.max", processors);
  for (const fs::path& part : OwnGroup(own)) {
    group /= part;
    processors = WithinQuota(group / "cpu.max", processors);
  }
  return processors;
}

}  // namespace powderkeg

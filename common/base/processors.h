#pragma once

// How much of a machine a process may use.

#include <filesystem>

namespace powderkeg {

// Threads that this process can run at once, at least 1: the processors that it may run on
// (affinity), as far as the processor time of its control groups allows (cgroup v2 `cpu.max`, as
// containers and services set it; in fractions it is rounded up). `groups` is where control groups
// are mounted, `own` the file that names the process's.
[[nodiscard]] int UsableProcessors(const std::filesystem::path& groups = "/sys/fs/cgroup",
                                   const std::filesystem::path& own = "/proc/self/cgroup");

}  // namespace powderkeg

#pragma once

// Numbers for names that must not meet: of runs, of processes.

#include <cstdint>
#include <functional>
#include <string>

namespace powderkeg {

// 64 bits that no other call, process or machine has drawn, for all practical purposes: those of
// `device` (the system's, if there is none), mixed with the time, the process, the host and a
// count. A device that throws or repeats itself is logged and done without. Nothing secret.
// Thread-safe.
[[nodiscard]] std::uint64_t UniqueNumber(const std::function<std::uint32_t()>& device = {});

// The name of this machine; empty if the system does not say.
[[nodiscard]] std::string HostName();

}  // namespace powderkeg

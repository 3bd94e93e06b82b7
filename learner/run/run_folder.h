#pragma once

// The folder of a run, runs/NAME: whose it is, what it is called and with which settings it goes
// on.

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "common/config/run_config.h"
#include "learner/run/run_claim.h"

namespace powderkeg {

// Only one learner at a time may own a run. Held until the lock is destroyed or the process ends.
class RunLock {
 public:
  // Throws Error if the folder is in use or cannot be written. Where the file system has no locks
  // it says so in the log and makes do with a RunClaim.
  explicit RunLock(const std::filesystem::path& folder);
  ~RunLock();
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;

 private:
  int file_;
  std::optional<RunClaim> claim_;
};

// The folder's name; of ".", that of the working directory. Throws Error if it is none
// (common/base/name.h).
[[nodiscard]] std::string RunNameOf(const std::filesystem::path& folder);

// The name and random digits, made at the run's first start and kept in run_id: actors must not mix
// runs up. Throws Error.
[[nodiscard]] std::string RunIdOf(const std::filesystem::path& folder);

// Settings are kept with the run (config.textproto): those of `file`, or of the run where `file` is
// empty, changed by `changes`. Throws Error as LoadConfig does, and if they change what stored
// games and weights are of: the rules, the boards, the network.
[[nodiscard]] RunConfig ConfigOfRun(const std::filesystem::path& folder, const std::string& file,
                                    std::span<const std::string> changes);

// Throws Error unless a learner may begin there, or go on, with these settings. Writes nothing.
void CheckRun(const std::filesystem::path& folder, const std::string& file,
              std::span<const std::string> changes);

void StoreConfig(const std::filesystem::path& folder, const RunConfig& config);

}  // namespace powderkeg

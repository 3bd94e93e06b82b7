#pragma once

// The folder of a run, runs/NAME: whose it is, what it is called, with which settings it goes on,
// and the files that it was given.

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/config/players.h"
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

// The settings with which a learner may begin there, or go on; throws Error if it may not. Writes
// nothing; warns where searches will take much memory.
RunConfig CheckRun(const std::filesystem::path& folder, const std::string& file,
                   std::span<const std::string> changes);

// From now on the run has begun.
void StoreConfig(const std::filesystem::path& folder, const RunConfig& config);

// A run that begins copies the files that it is given, and goes on from its copies, wherever that
// is and whatever became of the files.

// The files of demonstrations, in their order: copies of `given`, in demonstrations/. Throws Error
// if they cannot be copied, or are given to a run that began without.
[[nodiscard]] std::vector<std::filesystem::path> DemonstrationsOfRun(
    const std::filesystem::path& folder, std::span<const std::filesystem::path> given);

// Throws Error unless the run may begin, or goes on, when it is given these. Writes nothing.
void CheckDemonstrations(const std::filesystem::path& folder,
                         std::span<const std::filesystem::path> given,
                         const std::string& environment);

// The weights of a player that names a file, copied to players/ (also where a run that has begun
// names it only now). Throws Error if they cannot be read or copied.
[[nodiscard]] std::filesystem::path WeightsOfPlayer(const std::filesystem::path& folder,
                                                    const Player& player);

}  // namespace powderkeg

#pragma once

// Who owns a run on a file system without locks.

#include <chrono>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>

#include "common/base/worker.h"

namespace powderkeg {

// A file that says "HOST PROCESS NUMBER COUNT" and is written anew in every interval as long as its
// learner lives. Not as safe as a lock: of two learners that start in the same moment each finds
// the other in the log only.
class RunClaim {
 public:
  static constexpr std::chrono::milliseconds kInterval{5'000};

  // Where there is a claim already, waits three intervals whether it changes, unless its process
  // was one of this machine and has ended. Throws Error if it does, or cannot be written.
  explicit RunClaim(std::filesystem::path file, std::chrono::milliseconds interval = kInterval);
  // Removes the file, if it is still this one's.
  ~RunClaim();
  RunClaim(const RunClaim&) = delete;
  RunClaim& operator=(const RunClaim&) = delete;

 private:
  void ExpectNobody() const;
  void Renew(const std::stop_token& stop);
  // Whether the file still is this one's.
  [[nodiscard]] bool IsMine() const;

  const std::filesystem::path file_;
  const std::chrono::milliseconds interval_;
  const std::string owner_;  // "HOST PROCESS NUMBER"
  std::optional<Worker> worker_;
};

}  // namespace powderkeg

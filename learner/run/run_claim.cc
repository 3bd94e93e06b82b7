#include "learner/run/run_claim.h"

#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <condition_variable>
#include <fstream>
#include <mutex>
#include <sstream>
#include <system_error>
#include <thread>
#include <utility>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/durable_file.h"
#include "common/base/log.h"
#include "common/base/unique.h"

namespace powderkeg {
namespace {

constexpr int kIntervalsOfSilence = 3;

// Empty if there is none.
std::string ContentOf(const std::filesystem::path& file) {
  std::string line;
  std::getline(std::ifstream(file), line);
  return line;
}

// Whether a claim is of a process of this machine that is no more.
bool HasEnded(const std::string& claim) {
  std::istringstream words(claim);
  std::string host;
  pid_t process = 0;
  if (!(words >> host >> process) || process <= 0 || host != HostName()) return false;
  return kill(process, 0) != 0 && errno == ESRCH;
}

}  // namespace

RunClaim::RunClaim(std::filesystem::path file, std::chrono::milliseconds interval)
    : file_(std::move(file)),
      interval_(interval),
      owner_(StrCat(HostName(), ' ', getpid(), ' ', UniqueNumber())) {
  ExpectNobody();
  WriteFileDurably(file_, BytesOf(owner_ + " 0\n"));
  worker_.emplace("run claim", [this](const std::stop_token& stop) { Renew(stop); });
}

RunClaim::~RunClaim() {
  worker_.reset();
  std::error_code ignored;
  if (IsMine()) std::filesystem::remove(file_, ignored);
}

void RunClaim::ExpectNobody() const {
  const std::string found = ContentOf(file_);
  if (found.empty() || HasEnded(found)) return;
  log::Info("waiting whether another learner lives", "claim", found);
  std::this_thread::sleep_for(kIntervalsOfSilence * interval_);
  const std::string now = ContentOf(file_);
  if (now.empty() || now == found) return;
  throw Error(StrCat(file_.parent_path().string(), " is in use by another learner: ", now));
}

void RunClaim::Renew(const std::stop_token& stop) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any never;
  for (std::uint64_t count = 1;; ++count) {
    never.wait_for(lock, stop, interval_, [] { return false; });
    if (stop.stop_requested()) return;
    if (!IsMine())
      return log::Error("another learner has taken this run", "claim", ContentOf(file_));
    try {
      WriteFileDurably(file_, BytesOf(StrCat(owner_, ' ', count, '\n')));
    } catch (const Error& error) {
      log::Warn("cannot renew the claim on this run", "reason", error.what());
    }
  }
}

bool RunClaim::IsMine() const { return ContentOf(file_).starts_with(owner_ + ' '); }

}  // namespace powderkeg

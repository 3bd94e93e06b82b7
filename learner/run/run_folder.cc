#include "learner/run/run_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cinttypes>
#include <cstring>
#include <fstream>
#include <utility>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/durable_file.h"
#include "common/base/format.h"
#include "common/base/log.h"
#include "common/base/unique.h"
#include "common/config/config.h"

namespace powderkeg {
namespace {

std::filesystem::path StoredConfig(const std::filesystem::path& folder) {
  return folder / "config.textproto";
}

}  // namespace

RunLock::RunLock(const std::filesystem::path& folder) {
  const std::string path = (folder / "learner.lock").string();
  file_ = open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
  if (file_ < 0) throw Error(StrCat("cannot create ", path, ": ", std::strerror(errno)));
  if (flock(file_, LOCK_EX | LOCK_NB) == 0) return;
  const int reason = errno;
  close(std::exchange(file_, -1));
  if (reason == EWOULDBLOCK) throw Error(StrCat(folder.string(), " is in use by another learner"));
  if (reason != ENOLCK && reason != ENOTSUP && reason != ENOSYS && reason != EINVAL) {
    throw Error(StrCat("cannot lock ", path, ": ", std::strerror(reason)));
  }
  log::Warn("this file system has no locks: a second learner is noticed by learner.claim", "reason",
            std::strerror(reason));
  claim_.emplace(folder / "learner.claim");
}

RunLock::~RunLock() {
  if (file_ >= 0) close(file_);
}

std::string RunNameOf(const std::filesystem::path& folder) {
  constexpr std::size_t kLongest = 40;
  std::string name =
      (std::filesystem::absolute(folder) / "").lexically_normal().parent_path().filename().string();
  std::ranges::replace_if(
      name, [](unsigned char c) { return c <= ' ' || c > '~'; }, '_');
  return name.substr(0, kLongest);
}

std::string RunIdOf(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "run_id";
  std::string id;
  if (std::ifstream(path) >> id) return id;
  id = RunNameOf(folder) + "-" + Format("%016" PRIx64, UniqueNumber());
  WriteFileDurably(path, BytesOf(id + '\n'));
  return id;
}

RunConfig ConfigOfRun(const std::filesystem::path& folder, const std::string& file,
                      std::span<const std::string> changes) {
  std::string source = file;
  if (source.empty() && std::filesystem::exists(StoredConfig(folder))) {
    source = StoredConfig(folder).string();
  }
  return LoadConfig(source, changes);
}

void StoreConfig(const std::filesystem::path& folder, const RunConfig& config) {
  WriteFileDurably(StoredConfig(folder), BytesOf(ToText(config)));
}

}  // namespace powderkeg

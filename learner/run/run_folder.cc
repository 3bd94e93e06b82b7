#include "learner/run/run_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <random>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/durable_file.h"
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
  close(file_);
  if (reason == EWOULDBLOCK) throw Error(StrCat(folder.string(), " is in use by another learner"));
  throw Error(StrCat("cannot lock ", path, ": ", std::strerror(reason)));
}

RunLock::~RunLock() { close(file_); }

std::string RunNameOf(const std::filesystem::path& folder) {
  constexpr std::size_t kLongest = 40;
  std::string name = std::filesystem::absolute(folder / ".").parent_path().filename().string();
  std::ranges::replace_if(
      name, [](unsigned char c) { return c <= ' ' || c > '~'; }, '_');
  return name.substr(0, kLongest);
}

std::string RunIdOf(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "run_id";
  std::string id;
  if (std::ifstream(path) >> id) return id;
  std::random_device device;
  char text[33];
  std::snprintf(text, sizeof text, "%08x%08x", device(), device());
  id = RunNameOf(folder) + "-" + text;
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

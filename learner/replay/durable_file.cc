#include "learner/replay/durable_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

#include "common/base/check.h"

namespace powderkeg {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(std::string_view what, const fs::path& path, int error) {
  throw Error(StrCat("cannot ", what, " ", path.string(), ": ", std::strerror(error)));
}

// A file descriptor that is closed whatever happens.
class Descriptor {
 public:
  Descriptor(const fs::path& path, int flags) : path_(path), fd_(open(path.c_str(), flags, 0644)) {
    if (fd_ < 0) Fail("open", path_, errno);
  }
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  void Write(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
      const ssize_t written = write(fd_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) Fail("write", path_, errno);
      bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
  }
  void Sync() {
    if (fsync(fd_) != 0) Fail("flush", path_, errno);
  }
  void Close() {
    const int fd = fd_;
    fd_ = -1;
    if (close(fd) != 0) Fail("close", path_, errno);
  }

 private:
  fs::path path_;
  int fd_;
};

}  // namespace

void WriteFileDurably(const fs::path& path, std::span<const std::uint8_t> bytes) {
  fs::path temporary = path;
  temporary += kTemporaryEnding;
  Descriptor file(temporary, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC);
  file.Write(bytes);
  file.Sync();
  file.Close();
  if (std::rename(temporary.c_str(), path.c_str()) != 0) Fail("rename to", path, errno);
  SyncFolder(path.parent_path());
}

void RemoveFile(const fs::path& path) {
  if (unlink(path.c_str()) != 0) Fail("remove", path, errno);
}

void SyncFolder(const fs::path& folder) {
  Descriptor(folder.empty() ? fs::path(".") : folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC).Sync();
}

void PrepareFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) Fail("create", folder, error.value());
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == kTemporaryEnding) RemoveFile(entry.path());
  }
  if (error) Fail("list", folder, error.value());
}

std::vector<std::uint8_t> ReadFileBytes(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file) Fail("read", path, errno);
  return bytes;
}

}  // namespace powderkeg

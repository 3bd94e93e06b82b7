#include "common/base/durable_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <string>
#include <system_error>

#include "common/base/check.h"
#include "common/base/descriptors.h"
#include "common/base/log.h"

namespace powderkeg {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kReadBytes = std::size_t{1} << 16;

[[noreturn]] void Fail(std::string_view what, const fs::path& path, int error) {
  throw Error(StrCat("cannot ", what, " ", path.string(), ": ", std::strerror(error)));
}

// A file descriptor that is closed whatever happens.
class Descriptor {
 public:
  Descriptor(const fs::path& path, int flags) : path_(path) {
    const ReservedDescriptors reserved;
    fd_ = open(path.c_str(), flags, 0644);
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
  // From here on to the end.
  std::vector<std::uint8_t> Read(std::size_t bytes_at_once) {
    std::vector<std::uint8_t> bytes;
    for (std::size_t size = 0;;) {
      bytes.resize(size + bytes_at_once);
      const ssize_t got = read(fd_, bytes.data() + size, bytes_at_once);
      if (got < 0 && errno != EINTR) Fail("read", path_, errno);
      size += static_cast<std::size_t>(std::max<ssize_t>(got, 0));
      bytes.resize(size);
      if (got == 0) return bytes;
    }
  }
  // To `size` bytes before the end, or to the beginning.
  void SeekEnd(std::size_t size) {
    const off_t end = lseek(fd_, 0, SEEK_END);
    const off_t back = static_cast<off_t>(std::min(size, static_cast<std::size_t>(end)));
    if (end < 0 || lseek(fd_, -back, SEEK_END) < 0) Fail("read", path_, errno);
  }
  void Sync() {
    if (!TrySync()) Fail("flush", path_, errno);
  }
  // False: errno says why.
  [[nodiscard]] bool TrySync() { return fsync(fd_) == 0; }
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
  try {
    Descriptor file(temporary, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC);
    file.Write(bytes);
    file.Sync();
    file.Close();
    RenameFile(temporary, path);
  } catch (const Error&) {
    unlink(temporary.c_str());  // half a file would keep a full disk full
    throw;
  }
  SyncFolder(path.parent_path());
}

void RemoveFile(const fs::path& path) {
  if (unlink(path.c_str()) != 0) Fail("remove", path, errno);
}

void RenameFile(const fs::path& from, const fs::path& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0) Fail("rename to", to, errno);
}

void SyncFolder(const fs::path& folder) {
  static std::once_flag said;
  const fs::path path = folder.empty() ? fs::path(".") : folder;
  Descriptor descriptor(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor.TrySync()) return;
  const int error = errno;
  if (error != EINVAL && error != ENOTSUP && error != ENOSYS) Fail("flush", path, error);
  std::call_once(said, [&] {
    log::Warn(
        "this file system flushes no folders: a crash of the machine may undo the newest files",
        "folder", path.string(), "reason", std::strerror(error));
  });
}

void CreateFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) Fail("create", folder, error.value());
}

void PrepareFolder(const fs::path& folder) {
  CreateFolder(folder);
  for (const fs::path& path : FilesIn(folder)) {
    if (path.extension() == kTemporaryEnding) RemoveFile(path);
  }
}

std::vector<fs::path> FilesIn(const fs::path& folder) {
  const ReservedDescriptors reserved;
  std::vector<fs::path> paths;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    paths.push_back(entry->path());
  }
  if (error) Fail("list", folder, error.value());
  std::ranges::sort(paths, {}, [](const fs::path& path) -> const auto& { return path.native(); });
  return paths;
}

std::vector<std::uint8_t> ReadFileBytes(const fs::path& path) {
  return Descriptor(path, O_RDONLY | O_CLOEXEC).Read(kReadBytes);
}

std::vector<std::uint8_t> ReadFileEnd(const fs::path& path, std::size_t size) {
  Descriptor file(path, O_RDONLY | O_CLOEXEC);
  file.SeekEnd(size);
  return file.Read(std::min(size, kReadBytes) + 1);  // one more: the end is met at once
}

}  // namespace powderkeg

#include "actors/selfplay/outbox.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/durable_file.h"
#include "common/base/log.h"

namespace powderkeg {
namespace {

constexpr std::string_view kMagic = "PKSPOOL1";
constexpr std::size_t kEntryHeader = 8;
constexpr std::size_t kPayloadHeader = 8 + 4 + 32;
// A file with more dead bytes than living ones, and than this, is rewritten.
constexpr std::size_t kRewriteBytes = std::size_t{1} << 20;

[[noreturn]] void Fail(const std::string& what, const std::filesystem::path& path) {
  throw Error(StrCat("outbox: cannot ", what, " ", path, ": ", std::strerror(errno)));
}

void PutNumber(std::string& bytes, std::uint64_t number, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<char>(number >> (8 * i)));
}

std::uint64_t NumberAt(std::string_view bytes, std::size_t at, int size) {
  std::uint64_t number = 0;
  for (int i = size - 1; i >= 0; --i) {
    number = number << 8 | static_cast<std::uint8_t>(bytes[at + static_cast<std::size_t>(i)]);
  }
  return number;
}

std::string EntryOf(const SealedGame& game) {
  std::string payload;
  payload.reserve(kPayloadHeader + game.record.size());
  PutNumber(payload, game.ticket, 8);
  PutNumber(payload, game.checksum, 4);
  payload.append(game.settings_digest.begin(), game.settings_digest.end());
  payload.append(game.record);
  std::string entry;
  PutNumber(entry, payload.size(), 4);
  PutNumber(entry, Crc32c(BytesOf(payload)), 4);
  return entry + payload;
}

std::size_t EntrySize(const SealedGame& game) {
  return kEntryHeader + kPayloadHeader + game.record.size();
}

// The game at the front of `bytes`; nullopt if it is damaged or cut off.
std::optional<SealedGame> GameAt(std::string_view bytes) {
  if (bytes.size() < kEntryHeader + kPayloadHeader) return std::nullopt;
  const std::size_t size = NumberAt(bytes, 0, 4);
  if (size < kPayloadHeader || size > kPayloadHeader + kMaxRecordBytes ||
      size > bytes.size() - kEntryHeader) {
    return std::nullopt;
  }
  const std::string_view payload = bytes.substr(kEntryHeader, size);
  if (Crc32c(BytesOf(payload)) != NumberAt(bytes, 4, 4)) return std::nullopt;
  SealedGame game{.ticket = NumberAt(payload, 0, 8),
                  .record = std::string(payload.substr(kPayloadHeader)),
                  .checksum = static_cast<std::uint32_t>(NumberAt(payload, 8, 4)),
                  .settings_digest = {}};
  std::copy_n(payload.begin() + 12, game.settings_digest.size(), game.settings_digest.begin());
  return game;
}

int OpenLocked(const std::filesystem::path& path, int flags) {
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_APPEND | flags, 0644);
  if (file < 0) Fail("open", path);
  if (flock(file, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) Fail("lock", path);
    close(file);
    throw Error(StrCat("outbox: another actor uses ", path, "; give each its own --spool"));
  }
  return file;
}

void WriteAll(int file, std::string_view bytes, const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno != EINTR) Fail("write", path);
    if (written > 0) bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

std::string ReadAll(int file, const std::filesystem::path& path) {
  struct stat status {};
  if (fstat(file, &status) != 0) Fail("read", path);
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  for (std::size_t size = 0; size < bytes.size();) {
    const ssize_t got =
        pread(file, bytes.data() + size, bytes.size() - size, static_cast<off_t>(size));
    if (got < 0 && errno != EINTR) Fail("read", path);
    if (got == 0) throw Error(StrCat("outbox: ", path, " ends after ", size, " bytes"));
    size += static_cast<std::size_t>(std::max<ssize_t>(got, 0));
  }
  return bytes;
}

}  // namespace

Outbox::Outbox(const std::filesystem::path& folder, std::size_t limit_bytes)
    : path_(folder / "outbox.spool"), run_path_(folder / "run_id"), limit_bytes_(limit_bytes) {
  CreateFolder(folder);
  file_ = OpenLocked(path_, 0);
  std::error_code error;
  if (std::filesystem::exists(run_path_, error)) {
    const std::vector<std::uint8_t> run_id = ReadFileBytes(run_path_);
    run_id_.assign(run_id.begin(), run_id.end());
  }
  Load();
  syncer_ = std::make_unique<Worker>("spool", [this](const auto& stop) { RunSync(stop); });
}

Outbox::~Outbox() {
  syncer_.reset();
  close(file_);
}

void Outbox::Load() {
  const std::string bytes = ReadAll(file_, path_);
  if (bytes.size() < kMagic.size()) {  // new, or not even its name was written
    if (ftruncate(file_, 0) != 0) Fail("empty", path_);
    WriteAll(file_, kMagic, path_);
    file_bytes_ = kMagic.size();
    return;
  }
  if (!bytes.starts_with(kMagic)) {
    throw Error(StrCat("outbox: ", path_, " is not a spool; expected \"", kMagic, "\" first"));
  }
  std::size_t whole = 0;  // bytes of whole entries
  for (std::size_t at = file_bytes_ = kMagic.size(); at < bytes.size();) {
    auto game = GameAt(std::string_view(bytes).substr(at));
    if (!game) {
      ++at;  // the next entry may begin anywhere
      continue;
    }
    whole += EntrySize(*game);
    file_bytes_ = at += EntrySize(*game);
    if (!numbers_.emplace(game->ticket, last_number_ + 1).second) continue;
    record_bytes_ += game->record.size();
    games_.emplace(++last_number_, *std::move(game));
  }
  const std::size_t damaged = bytes.size() - kMagic.size() - whole;
  if (damaged == 0) return;
  log::Warn("outbox: dropped what is damaged", "file", path_.string(), "bytes", damaged,
            "games_left", games_.size());
  if (file_bytes_ > kMagic.size() + whole) return Rewrite();
  if (ftruncate(file_, static_cast<off_t>(file_bytes_)) != 0) Fail("shorten", path_);
}

std::vector<std::uint64_t> Outbox::ServeRun(const std::string& run_id) {
  std::vector<std::uint64_t> tickets;
  if (run_id == run_id_) return tickets;
  if (!run_id_.empty()) tickets = SetAside();
  WriteFileDurably(run_path_, BytesOf(run_id));
  run_id_ = run_id;
  return tickets;
}

std::vector<std::uint64_t> Outbox::SetAside() {
  const std::lock_guard lock(mutex_);
  std::vector<std::uint64_t> tickets;
  for (const auto& [ticket, number] : numbers_) tickets.push_back(ticket);
  if (tickets.empty()) return tickets;
  std::string run = run_id_;
  std::ranges::replace(run, '/', '_');
  std::filesystem::path aside;
  std::error_code error;
  for (int i = 1; aside.empty() || std::filesystem::exists(aside, error); ++i) {
    aside = path_.parent_path() / StrCat("outbox-", run, i == 1 ? "" : StrCat("-", i), ".spool");
  }
  if (std::rename(path_.c_str(), aside.c_str()) != 0) Fail("rename", path_);
  const int file = OpenLocked(path_, 0);
  WriteAll(file, kMagic, path_);
  close(file_);
  file_ = file;
  file_bytes_ = kMagic.size();
  log::Warn("set games of another run aside", "run", run_id_, "games", tickets.size(), "file",
            aside.string());
  games_.clear();
  numbers_.clear();
  record_bytes_ = 0;
  removed_.notify_all();
  return tickets;
}

void Outbox::Add(SealedGame game) {
  const std::lock_guard lock(mutex_);
  if (numbers_.contains(game.ticket)) return;
  if (sync_failed_) throw Error(StrCat("outbox: the disk of ", path_, " has failed"));
  Append(EntryOf(game));
  record_bytes_ += game.record.size();
  numbers_[game.ticket] = ++last_number_;
  games_.emplace(last_number_, std::move(game));
  unsynced_ = true;
}

// Half an entry would hide those that come after it.
void Outbox::Append(const std::string& entry) {
  try {
    WriteAll(file_, entry, path_);
  } catch (const Error&) {
    if (ftruncate(file_, static_cast<off_t>(file_bytes_)) != 0) Fail("shorten", path_);
    throw;
  }
  file_bytes_ += entry.size();
}

// Under a copy of the descriptor: whoever adds games or rewrites the file does not wait.
void Outbox::RunSync(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    stopped_.wait_for(lock, stop, kSyncInterval, [] { return false; });
    if (!std::exchange(unsynced_, false)) continue;
    const int file = fcntl(file_, F_DUPFD_CLOEXEC, 0);
    lock.unlock();
    const bool synced = file >= 0 && fdatasync(file) == 0;
    if (!synced) log::Error("outbox: cannot sync", "file", path_.string(), "error", errno);
    if (file >= 0) close(file);
    lock.lock();
    sync_failed_ = !synced;
  }
}

void Outbox::Remove(std::uint64_t ticket) {
  {
    const std::lock_guard lock(mutex_);
    const auto number = numbers_.find(ticket);
    if (number == numbers_.end()) return;
    const auto game = games_.find(number->second);
    record_bytes_ -= game->second.record.size();
    games_.erase(game);
    numbers_.erase(number);
    removed_.notify_all();
    if (games_.empty()) {
      file_bytes_ = kMagic.size();
      if (ftruncate(file_, static_cast<off_t>(file_bytes_)) != 0) Fail("empty", path_);
    }
    if (file_bytes_ <= 2 * record_bytes_ + kRewriteBytes) return;
  }
  Rewrite();
}

// Whole or not at all: temporary file, fsync, rename. What is added meanwhile is added to it.
void Outbox::Rewrite() {
  const std::filesystem::path temporary = path_.string() + ".new";
  const int file = OpenLocked(temporary, O_TRUNC);
  std::string bytes(kMagic);
  std::uint64_t written = 0;
  const auto collect = [&] {
    for (auto game = games_.upper_bound(written); game != games_.end(); ++game) {
      bytes += EntryOf(game->second);
      written = game->first;
    }
  };
  std::unique_lock lock(mutex_);
  collect();
  lock.unlock();
  WriteAll(file, bytes, temporary);
  if (fdatasync(file) != 0) Fail("sync", temporary);
  lock.lock();
  const std::size_t synced = bytes.size();
  collect();
  WriteAll(file, std::string_view(bytes).substr(synced), temporary);
  if (std::rename(temporary.c_str(), path_.c_str()) != 0) Fail("rename", temporary);
  close(file_);
  file_ = file;
  file_bytes_ = bytes.size();
  unsynced_ = true;
}

std::vector<SealedGame> Outbox::Batch(std::uint64_t& cursor, std::size_t max_bytes) const {
  const std::lock_guard lock(mutex_);
  std::vector<SealedGame> batch;
  std::size_t bytes = 0;
  for (auto game = games_.upper_bound(cursor); game != games_.end(); ++game) {
    bytes += game->second.record.size();
    if (!batch.empty() && bytes > max_bytes) break;
    batch.push_back(game->second);
    cursor = game->first;
  }
  return batch;
}

std::vector<std::uint64_t> Outbox::Tickets() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::uint64_t> tickets;
  for (const auto& [ticket, number] : numbers_) tickets.push_back(ticket);
  return tickets;
}

void Outbox::WaitForRoom(std::chrono::milliseconds timeout) const {
  std::unique_lock lock(mutex_);
  removed_.wait_for(lock, timeout, [&] { return record_bytes_ < limit_bytes_; });
}

std::size_t Outbox::size() const {
  const std::lock_guard lock(mutex_);
  return games_.size();
}

std::size_t Outbox::bytes() const {
  const std::lock_guard lock(mutex_);
  return record_bytes_;
}

}  // namespace powderkeg

#include "learner/run/run_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cinttypes>
#include <cstring>
#include <fstream>
#include <string_view>
#include <utility>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/durable_file.h"
#include "common/base/format.h"
#include "common/base/log.h"
#include "common/base/name.h"
#include "common/base/unique.h"
#include "common/config/config.h"
#include "common/config/tree_memory.h"
#include "common/model/model_name.h"
#include "common/model/network_description.h"
#include "learner/replay/demonstrations.h"

namespace powderkeg {
namespace {

constexpr std::size_t kLongestInId = 40;
constexpr std::string_view kDemonstrations = "demonstrations";

// What a run keeps: its games, weights and table are of these.
constexpr std::array<std::string_view, 4> kKept = {"environment", "board_generator", "corners",
                                                   "network"};

std::filesystem::path StoredConfig(const std::filesystem::path& folder) {
  return folder / "config.textproto";
}

bool HasBegun(const std::filesystem::path& folder) {
  return std::filesystem::exists(StoredConfig(folder));
}

// Throws Error where a run goes on without demonstrations that it is given.
void RequireDemonstrations(const std::filesystem::path& kept, bool given) {
  if (!given || std::filesystem::exists(kept)) return;
  throw Error(StrCat("demonstrations are given, but this run has no ", kept.string(),
                     ": it began without; expected a new run, or none"));
}

template <typename Settings>
void RequireKept(std::string_view path, OptionTable<Settings> table, const Settings& before,
                 const Settings& now) {
  for (const Option<Settings>& option : table) {
    const std::string old_value = option.write(before, option.allowed);
    const std::string value = option.write(now, option.allowed);
    if (value == old_value || std::ranges::find(kKept, option.name) == kKept.end()) continue;
    throw Error(StrCat(path, option.name, " is ", Quoted(value), ", but this run began with ",
                       Quoted(old_value), "; expected a new run, or the same ", Joined(kKept, ", "),
                       ": the other settings may change"));
  }
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
  const std::filesystem::path path = (folder / ".").parent_path();
  const std::string name = (path == "." ? std::filesystem::current_path() : path).filename();
  RequireName("the run's name", name);
  return name;
}

std::string RunIdOf(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "run_id";
  std::string id;
  if (std::ifstream(path) >> id) return id;
  id = RunNameOf(folder).substr(0, kLongestInId) + "-" + Format("%016" PRIx64, UniqueNumber());
  WriteFileDurably(path, BytesOf(id + '\n'));
  return id;
}

RunConfig ConfigOfRun(const std::filesystem::path& folder, const std::string& file,
                      std::span<const std::string> changes) {
  if (!HasBegun(folder)) return LoadConfig(file, changes);
  const std::string stored = StoredConfig(folder).string();
  const RunConfig before = LoadConfig(stored, {});
  const RunConfig now = LoadConfig(file.empty() ? stored : file, changes);
  RequireKept("self_play.", SelfPlayOptions(), before.self_play, now.self_play);
  RequireKept("training.", TrainingOptions(), before.training, now.training);
  return now;
}

RunConfig CheckRun(const std::filesystem::path& folder, const std::string& file,
                   std::span<const std::string> changes) {
  static_cast<void>(RunNameOf(folder));
  RunConfig config = ConfigOfRun(folder, file, changes);
  static_cast<void>(NetworkByName(config.training.network));
  WarnOfTrees("each game loop of an actor", TreeBytesOfLoop(config.self_play));
  return config;
}

void StoreConfig(const std::filesystem::path& folder, const RunConfig& config) {
  WriteFileDurably(StoredConfig(folder), BytesOf(ToText(config)));
}

std::vector<std::filesystem::path> DemonstrationsOfRun(
    const std::filesystem::path& folder, std::span<const std::filesystem::path> given) {
  const std::filesystem::path kept = folder / kDemonstrations;
  if (HasBegun(folder)) {
    RequireDemonstrations(kept, !given.empty());
  } else {
    std::filesystem::remove_all(kept);  // of a start that failed
    if (!given.empty()) CreateFolder(kept);
    for (std::size_t i = 0; i < given.size(); ++i) {
      const std::string name = Format("%06zu-", i) + given[i].filename().string();
      WriteFileDurably(kept / name, ReadFileBytes(given[i]));
    }
  }
  if (!std::filesystem::exists(kept)) return {};
  return FilesIn(kept);
}

void CheckDemonstrations(const std::filesystem::path& folder,
                         std::span<const std::filesystem::path> given,
                         const std::string& environment) {
  if (HasBegun(folder)) {
    RequireDemonstrations(folder / kDemonstrations, !given.empty());
  } else {
    ReadDemonstrations(given, environment, [](const Lessons&) {});
  }
}

std::filesystem::path WeightsOfPlayer(const std::filesystem::path& folder, const Player& player) {
  const std::uint32_t code = Crc32c(BytesOf(player.weights_file));  // another file, another copy
  const std::filesystem::path kept =
      folder / "players" / Format("%s-%08" PRIx32 ".weights", player.name.c_str(), code);
  if (!HasBegun(folder) || !std::filesystem::exists(kept)) {
    const Snapshot weights = LoadModel(player.weights_file);
    CreateFolder(kept.parent_path());
    SaveSnapshot(*weights, kept.string());
  }
  return kept;
}

}  // namespace powderkeg

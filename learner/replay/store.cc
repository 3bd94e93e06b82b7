#include "learner/replay/store.h"

#include <algorithm>
#include <iomanip>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <unordered_set>
#include <utility>

#include "common/base/check.h"
#include "common/base/descriptors.h"
#include "common/base/durable_file.h"
#include "common/base/log.h"
#include "common/base/number.h"
#include "common/record/ticket_set.h"
#include "common/segment/segment_file.h"

namespace powderkeg {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = "segment-";
constexpr std::string_view kEnding = ".h5";

// Segments that reached this size stay as they are.
constexpr std::uint64_t kMergeBelowBytes = std::uint64_t{64} << 20;

// The number of a segment's file name, nullopt for other files.
std::optional<std::uint64_t> SegmentNumber(const fs::path& path) {
  const std::string name = path.filename().string();
  if (!name.starts_with(kPrefix) || !name.ends_with(kEnding)) return std::nullopt;
  const std::size_t digits = name.size() - kPrefix.size() - kEnding.size();
  return ParseNumber<std::uint64_t>(std::string_view(name).substr(kPrefix.size(), digits));
}

bool IsSmall(std::uint64_t bytes) { return bytes < kMergeBelowBytes; }

std::uint64_t SizeOf(const fs::path& path) {
  std::error_code error;
  const std::uint64_t size = fs::file_size(path, error);
  if (error) throw Error(StrCat("cannot read ", path.string(), ": ", error.message()));
  return size;
}

// Loads segment after segment.
struct Loading {
  const std::function<bool(std::uint64_t)>& wanted;
  const std::function<void(GameRecord&&)>& visit;
  TicketSet seen;
  std::vector<std::uint64_t> stored;

  // False: the segment is damaged; its games were visited as far as they are whole.
  bool Load(const fs::path& path) {
    const auto tickets = ReadTickets(path);
    if (!tickets) return false;
    std::unordered_set<std::uint64_t> missing;
    for (const std::uint64_t ticket : *tickets) {
      if (!seen.Contains(ticket) && wanted(ticket)) missing.insert(ticket);
    }
    SegmentDamage damage;
    if (!missing.empty()) {
      damage = ReadSegment(path, [&](GameRecord&& game) {
        if (missing.erase(game.ticket) != 0) visit(std::move(game));
      });
    }
    for (const std::uint64_t ticket : *tickets) {
      if (!missing.contains(ticket) && seen.Insert(ticket)) stored.push_back(ticket);
    }
    return damage.reason.empty();
  }
};

}  // namespace

ReplayStore::ReplayStore(fs::path folder) : folder_(std::move(folder)) {
  PrepareFolder(folder_);
  for (const fs::path& path : FilesIn(folder_)) {
    if (const auto number = SegmentNumber(path)) segments_.push_back({*number, SizeOf(path)});
  }
  std::ranges::sort(segments_, {}, &Segment::number);
}

fs::path ReplayStore::PathOf(const Segment& segment) const {
  std::ostringstream name;
  name << kPrefix << std::setw(8) << std::setfill('0') << segment.number << kEnding;
  return folder_ / name.str();
}

void ReplayStore::Append(std::span<const GameRecord> games) {
  if (games.empty()) return;
  const std::vector<std::uint8_t> bytes = EncodeSegment(games);
  const Segment segment{segments_.empty() ? 1 : segments_.back().number + 1, bytes.size()};
  WriteFileDurably(PathOf(segment), bytes);
  segments_.push_back(segment);
}

std::vector<std::uint64_t> ReplayStore::Load(const std::function<bool(std::uint64_t)>& wanted,
                                             const std::function<void(GameRecord&&)>& visit) {
  const ReservedDescriptors reserved;  // once for all of them
  Loading loading{.wanted = wanted, .visit = visit, .seen = TicketSet(), .stored = {}};
  for (std::size_t i = 0; i < segments_.size();) {
    const Segment segment = segments_[i];
    if (loading.Load(PathOf(segment))) {
      ++i;
    } else {
      Rewrite(std::span(&segment, 1));  // its games come again, at the end
    }
  }
  return std::move(loading.stored);
}

std::size_t ReplayStore::small_segment_count() const {
  return static_cast<std::size_t>(std::ranges::count_if(segments_, IsSmall, &Segment::bytes));
}

std::size_t ReplayStore::Trim(std::uint64_t max_bytes,
                              const std::function<bool(std::uint64_t)>& wanted) {
  std::uint64_t bytes = 0;
  for (const Segment& segment : segments_) bytes += segment.bytes;
  const std::size_t removed = std::erase_if(segments_, [&](const Segment& segment) {
    if (bytes <= max_bytes) return false;
    const auto tickets = ReadTickets(PathOf(segment));
    if (!tickets || std::ranges::any_of(*tickets, wanted)) return false;
    RemoveFile(PathOf(segment));
    bytes -= segment.bytes;
    return true;
  });
  if (removed > 0) SyncFolder(folder_);
  return removed;
}

void ReplayStore::Merge() {
  std::vector<Segment> batch;
  std::uint64_t bytes = 0;
  for (const Segment& segment : std::vector(segments_)) {
    if (!IsSmall(segment.bytes)) continue;
    batch.push_back(segment);
    bytes += segment.bytes;
    if (IsSmall(bytes)) continue;
    if (batch.size() > 1) Rewrite(batch);
    batch.clear();
    bytes = 0;
  }
  if (batch.size() > 1) Rewrite(batch);
}

void ReplayStore::Rewrite(std::span<const Segment> originals) {
  std::vector<GameRecord> games;
  std::vector<SegmentDamage> damages;
  TicketSet seen;
  for (const Segment& segment : originals) {
    damages.push_back(ReadSegment(PathOf(segment), [&](GameRecord&& game) {
      if (seen.Insert(game.ticket)) games.push_back(std::move(game));
    }));
  }
  Append(games);
  for (std::size_t i = 0; i < originals.size(); ++i) {
    if (damages[i].reason.empty()) {
      RemoveFile(PathOf(originals[i]));
    } else {
      SetAside(PathOf(originals[i]), damages[i]);
    }
  }
  SyncFolder(folder_);
  std::erase_if(segments_, [&](const Segment& segment) {
    return std::ranges::find(originals, segment.number, &Segment::number) != originals.end();
  });
}

void ReplayStore::SetAside(const fs::path& path, const SegmentDamage& damage) {
  fs::path aside = path;
  do aside += ".damaged";
  while (fs::exists(aside));
  RenameFile(path, aside);
  log::Warn("a segment is damaged: its whole games are kept, the file is set aside", "file",
            aside.string(), "reason", damage.reason, "tickets_lost", LostText(damage));
  if (damage.lost) lost_.insert(lost_.end(), damage.lost->begin(), damage.lost->end());
}

}  // namespace powderkeg

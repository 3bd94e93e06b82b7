#include "learner/replay/store.h"

#include <algorithm>
#include <charconv>
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
#include "common/base/durable_file.h"
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
  const char* begin = name.data() + kPrefix.size();
  const char* end = name.data() + name.size() - kEnding.size();
  std::uint64_t number = 0;
  const auto [rest, error] = std::from_chars(begin, end, number);
  if (error != std::errc() || rest != end) return std::nullopt;
  return number;
}

bool IsSmall(std::uint64_t bytes) { return bytes < kMergeBelowBytes; }

constexpr auto kAll = [](std::uint64_t) { return true; };

std::uint64_t SizeOf(const fs::path& path) {
  std::error_code error;
  const std::uint64_t size = fs::file_size(path, error);
  if (error) throw Error(StrCat("cannot read ", path.string(), ": ", error.message()));
  return size;
}

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

void ReplayStore::LoadFrom(std::span<const Segment> segments,
                           const std::function<bool(std::uint64_t)>& wanted,
                           const std::function<void(GameRecord&&)>& visit) const {
  TicketSet seen;
  for (const Segment& segment : segments) {
    std::unordered_set<std::uint64_t> chosen;
    for (const std::uint64_t ticket : ReadTickets(PathOf(segment))) {
      if (seen.Insert(ticket) && wanted(ticket)) chosen.insert(ticket);
    }
    if (chosen.empty()) continue;
    ReadSegment(PathOf(segment), [&](GameRecord&& game) {
      if (chosen.erase(game.ticket) != 0) visit(std::move(game));
    });
  }
}

void ReplayStore::Load(const std::function<void(GameRecord&&)>& visit) const {
  LoadFrom(segments_, kAll, visit);
}

void ReplayStore::Load(const std::function<bool(std::uint64_t)>& wanted,
                       const std::function<void(GameRecord&&)>& visit) const {
  LoadFrom(segments_, wanted, visit);
}

std::size_t ReplayStore::small_segment_count() const {
  return static_cast<std::size_t>(std::ranges::count_if(segments_, IsSmall, &Segment::bytes));
}

std::size_t ReplayStore::Trim(std::uint64_t max_bytes,
                              const std::function<bool(std::uint64_t)>& wanted) {
  std::uint64_t bytes = 0;
  for (const Segment& segment : segments_) bytes += segment.bytes;
  const std::size_t removed = std::erase_if(segments_, [&](const Segment& segment) {
    if (bytes <= max_bytes || std::ranges::any_of(ReadTickets(PathOf(segment)), wanted))
      return false;
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
    MergeAll(batch);
    batch.clear();
    bytes = 0;
  }
  MergeAll(batch);
}

void ReplayStore::MergeAll(std::span<const Segment> originals) {
  if (originals.size() < 2) return;
  std::vector<GameRecord> games;
  LoadFrom(originals, kAll, [&](GameRecord&& game) { games.push_back(std::move(game)); });
  Append(games);
  for (const Segment& segment : originals) RemoveFile(PathOf(segment));
  SyncFolder(folder_);
  std::erase_if(segments_, [&](const Segment& segment) {
    return std::ranges::find(originals, segment.number, &Segment::number) != originals.end();
  });
}

}  // namespace powderkeg

#include "learner/replay/store.h"

#include <algorithm>
#include <charconv>
#include <iomanip>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "common/segment/segment_file.h"
#include "learner/replay/durable_file.h"

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

}  // namespace

ReplayStore::ReplayStore(fs::path folder) : folder_(std::move(folder)) {
  PrepareFolder(folder_);
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    if (const auto number = SegmentNumber(entry.path())) {
      segments_.push_back({*number, entry.file_size()});
    }
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
                           const std::function<void(GameRecord&&)>& visit) const {
  std::unordered_set<std::uint64_t> seen;
  for (const Segment& segment : segments) {
    ReadSegment(PathOf(segment), [&](GameRecord&& game) {
      if (seen.insert(game.ticket).second) visit(std::move(game));
    });
  }
}

void ReplayStore::Load(const std::function<void(GameRecord&&)>& visit) const {
  LoadFrom(segments_, visit);
}

void ReplayStore::Merge() {
  const auto small = std::ranges::stable_partition(
      segments_, [](const Segment& segment) { return segment.bytes >= kMergeBelowBytes; });
  const std::vector<Segment> originals(small.begin(), small.end());
  std::ranges::sort(segments_, {}, &Segment::number);
  if (originals.size() < 2) return;
  std::vector<GameRecord> games;
  LoadFrom(originals, [&](GameRecord&& game) { games.push_back(std::move(game)); });
  Append(games);
  for (const Segment& segment : originals) RemoveFile(PathOf(segment));
  SyncFolder(folder_);
  std::erase_if(segments_, [&](const Segment& segment) {
    return std::ranges::find(originals, segment.number, &Segment::number) != originals.end();
  });
}

}  // namespace powderkeg

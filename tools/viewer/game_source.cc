#include "tools/viewer/game_source.h"

#include <iostream>
#include <memory>
#include <utility>
#include <vector>

#include "common/base/check.h"

namespace powderkeg {
namespace {

GameSource RecordedSource(const std::string& file) {
  return [reader = std::make_shared<RecordedGameReader>(file)](StoredGame& stored) {
    stored = {};
    return reader->Next(stored.game);
  };
}

GameSource SegmentSource(const std::string& file) {
  std::vector<GameRecord> records;
  const SegmentDamage damage =
      ReadSegment(file, [&](GameRecord&& record) { records.push_back(std::move(record)); });
  if (!damage.reason.empty()) {
    std::cerr << LeftOutText(file, damage) << '\n';
  }
  return [records = std::move(records), next = std::size_t{0}](StoredGame& stored) mutable {
    if (next == records.size()) return false;
    stored = StoredGameFrom(records[next++]);
    return true;
  };
}

}  // namespace

std::string LeftOutText(const std::string& file, const SegmentDamage& damage) {
  return StrCat(file, ": ", damage.reason, "; its games of tickets ", LostText(damage),
                " are left out");
}

bool IsSegment(const std::string& file) { return file.find(".h5") != std::string::npos; }

GameSource OpenGames(const std::string& file) {
  return IsSegment(file) ? SegmentSource(file) : RecordedSource(file);
}

}  // namespace powderkeg

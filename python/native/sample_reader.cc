#include "python/native/sample_reader.h"

#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "common/segment/segment_file.h"

namespace powderkeg {

SampleReader::SampleReader(const std::filesystem::path& path) : name_(path.string()) {
  if (name_.ends_with(".jsonl") || name_.ends_with(".jsonl.gz")) {
    recorded_ = std::make_unique<RecordedGameReader>(name_);
    return;
  }
  const SegmentDamage damage =
      ReadSegment(path, [&](GameRecord&& game) { records_.push_back(std::move(game)); });
  if (damage.reason.empty()) return;
  if (!damage.lost && records_.empty()) throw Error(StrCat("segment ", name_, ": ", damage.reason));
  damages_.push_back(
      StrCat("segment ", name_, ": ", damage.reason, "; lost games: ", LostText(damage)));
}

std::vector<TicketedSample> SampleReader::Next(std::size_t count) {
  while (samples_.size() < count && ReadGame()) {
  }
  const auto end = samples_.begin() + static_cast<std::ptrdiff_t>(std::min(count, samples_.size()));
  std::vector<TicketedSample> samples(samples_.begin(), end);
  samples_.erase(samples_.begin(), end);
  return samples;
}

bool SampleReader::ReadGame() {
  if (recorded_) {
    RecordedGame game;
    if (!recorded_->Next(game)) return false;
    const std::uint64_t ticket = next_game_++;
    if (game.Known()) Take(MakeLessons(game, ticket), game.settings, ticket);
    return true;
  }
  if (next_game_ == records_.size()) return false;
  const GameRecord& game = records_[next_game_++];
  Take(MakeLessons(game), game.setup.settings, game.ticket);
  return true;
}

void SampleReader::Take(std::variant<Lessons, std::string>&& lessons, const GameSettings& settings,
                        std::uint64_t ticket) {
  if (const auto* reason = std::get_if<std::string>(&lessons)) {
    damages_.push_back(StrCat(name_, ": game ", ticket, ": ", *reason));
    return;
  }
  for (const Sample& sample : std::get<Lessons>(lessons).samples) {
    samples_.push_back({sample, ticket, settings});
  }
}

}  // namespace powderkeg

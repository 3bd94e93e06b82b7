#pragma once

// The stored games of a file, one after the other.

#include <functional>
#include <string>

#include "common/segment/segment_file.h"
#include "tools/viewer/stored_game.h"

namespace powderkeg {

// The next game; false at the end. Throws Error where the file holds something else.
using GameSource = std::function<bool(StoredGame& game)>;

// Whether a file of this name is a segment of a run; otherwise it is recorded games.
[[nodiscard]] bool IsSegment(const std::string& file);

// What to say of a damaged segment.
[[nodiscard]] std::string LeftOutText(const std::string& file, const SegmentDamage& damage);

// Of a segment, or of recorded games (.jsonl, .jsonl.gz). What a damaged segment has lost is said
// on standard error. Throws Error if the file cannot be read.
[[nodiscard]] GameSource OpenGames(const std::string& file);

}  // namespace powderkeg

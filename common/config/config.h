#pragma once

// The settings of a run: from a file and the command line, and back to text. Format, ranges and
// defaults: proto/config.proto.

#include <span>
#include <string>
#include <string_view>

#include "common/base/digest.h"
#include "common/config/run_config.h"

namespace powderkeg {

// The defaults, changed by the file (unless `path` is empty), then by `changes` in order, each
// "path=value" such as "training.batch_size=128" or "self_play.search.simulations=64"; a list's
// values are separated by commas. Throws Error: the file, line and column or the change, and what
// was expected. Names of environments, policies and search options are checked by those who own
// them.
[[nodiscard]] RunConfig LoadConfig(const std::string& path, std::span<const std::string> changes);

// The same from text; `place` names it in errors.
[[nodiscard]] RunConfig ParseConfig(const std::string& text, const std::string& place,
                                    std::span<const std::string> changes);

// Every setting by name, in the format of the file: ParseConfig gives an equal config.
[[nodiscard]] std::string ToText(const RunConfig& config);
[[nodiscard]] std::string ToText(const SelfPlayConfig& config);

// Ends of games are worth the same in training as in the search: training.draw_value and
// late_win_value, where they are not set, become the search's (self_play.search), where those are.
// Throws Error if the search's are no numbers from -1 to +1.
void TieOutcomesToSearch(RunConfig& config);

// Equal for equal settings, whatever program made it: SHA-256 of ToText.
[[nodiscard]] Sha256Digest SettingsDigest(const SelfPlayConfig& config);

}  // namespace powderkeg

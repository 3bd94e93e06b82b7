#pragma once

// The settings of a run: from a file and the command line, and back to text (settings_text.h).

#include <span>
#include <string>
#include <string_view>

#include "common/base/digest.h"
#include "common/config/run_config.h"

namespace powderkeg {

// The defaults, changed by the file (unless `path` is empty), then by `changes` in order, each
// "path=value" such as "training.batch_size=128" or "self_play.search.simulations=64"; a list's
// words are separated by commas. Within a section a preset comes first; among the changes it
// replaces what was said before, by the file too. What was left open is filled in: players,
// line-ups. Throws Error: the file, line and column or the change, and what was expected; whatever
// an actor would refuse is refused here.
[[nodiscard]] RunConfig LoadConfig(const std::string& path, std::span<const std::string> changes);

// The same from text; `place` names it in errors.
[[nodiscard]] RunConfig ParseConfig(std::string_view text, const std::string& place,
                                    std::span<const std::string> changes);
// What ToText made of settings of games; nothing is filled in. Throws Error as ParseConfig does.
[[nodiscard]] SelfPlayConfig ParseSelfPlay(std::string_view text);

// Every setting by name: ParseConfig gives an equal config.
[[nodiscard]] std::string ToText(const RunConfig& config);
[[nodiscard]] std::string ToText(const SelfPlayConfig& config);

// Ends of games are worth the same in training as in the search: training.draw_value and
// late_win_value, where they are not set, become the search's.
void TieOutcomesToSearch(RunConfig& config);

// Equal for equal settings, whatever program made it: SHA-256 of ToText.
[[nodiscard]] Sha256Digest SettingsDigest(const SelfPlayConfig& config);

// Every setting with default, meaning and range, for --help-options.
[[nodiscard]] std::string SettingsHelp();

}  // namespace powderkeg

#include "learner/replay/demonstrations.h"

#include <cstdint>
#include <utility>

#include "common/base/check.h"
#include "common/base/log.h"
#include "common/pommerman/game_settings.h"
#include "common/recorded/recorded_game.h"

namespace powderkeg {
namespace {

// "PommeTeam-v1 (team, 800 steps, blast cap 4, view 4, collapses 500 575 650 725)".
std::string RulesOf(const RecordedGame& game) {
  if (!game.Known()) return game.mode;
  const GameSettings& settings = game.settings;
  std::string text =
      StrCat(game.environment, " (", game.mode, ", ", settings.max_steps, " steps, blast cap ",
             settings.blast_strength_cap, ", view ", settings.view_radius, ", collapses");
  for (const int step : settings.collapse_steps) text += StrCat(' ', step);
  return text + ")";
}

// The games of one file, with tickets from `ticket` on; the next ticket.
std::uint64_t ReadFile(const std::string& file, const GameSettings& rules, std::uint64_t ticket,
                       const std::function<void(Lessons&&)>& visit) {
  RecordedGameReader reader(file);
  std::size_t decisions = 0;
  std::size_t others = 0;
  std::string other;  // the first of them
  for (RecordedGame game; reader.Next(game);) {
    if (!game.Known() || game.settings != rules) {
      if (others++ == 0) other = StrCat(game.id, " is of ", RulesOf(game));
      continue;
    }
    auto made = MakeLessons(game, ticket);
    if (const auto* reason = std::get_if<std::string>(&made)) {
      throw Error(StrCat(file, ": ", game.id, ": ", *reason));
    }
    auto& lessons = std::get<Lessons>(made);
    if (lessons.samples.empty()) continue;
    decisions += lessons.samples.size();
    visit(std::move(lessons));
    ++ticket;
  }
  if (decisions == 0) {
    throw Error(StrCat(file, ": nothing to learn from", others > 0 ? ": " + other : ""));
  }
  if (others > 0) {
    log::Warn("demonstrations of other rules are left out", "file", file, "games", others, "first",
              other);
  }
  return ticket;
}

}  // namespace

void ReadDemonstrations(std::span<const std::filesystem::path> files,
                        const std::string& environment,
                        const std::function<void(Lessons&&)>& visit) {
  const GameSettings rules = GameSettingsFor(environment).value();
  std::uint64_t ticket = 0;
  for (const std::filesystem::path& file : files) {
    try {
      ticket = ReadFile(file.string(), rules, ticket, visit);
    } catch (const Error& error) {
      throw Error(StrCat("demonstrations: ", error.what(), "; expected games of ", environment,
                         " (self_play.environment), recorded as replay --export does"));
    }
  }
}

}  // namespace powderkeg

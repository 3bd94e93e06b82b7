#include "common/record/game_setup.h"

#include <cstddef>
#include <optional>

#include "common/base/check.h"
#include "common/base/rng.h"
#include "common/pommerman/game_settings.h"

namespace powderkeg {
namespace {

GameSettings SettingsOf(const SelfPlayConfig& config) {
  const std::optional<GameSettings> settings = GameSettingsFor(config.environment);
  if (!settings) {
    throw Error(StrCat("environment \"", config.environment, "\" is unknown; expected one of ",
                       KnownEnvironmentIds()));
  }
  return *settings;
}

StartSettings StartOf(const SelfPlayConfig& config) {
  return {
      .generator = config.board_generator == "uniform" ? BoardGenerator::kUniform
                                                       : BoardGenerator::kOfficial,
      .corners = config.corners == "permuted" ? StartCorners::kPermuted : StartCorners::kOfficial};
}

}  // namespace

RunGames::RunGames(const SelfPlayConfig& config)
    : settings_(SettingsOf(config)),
      start_(StartOf(config)),
      table_(ResolvePlayers(config)),
      seed_(config.seed),
      to_the_end_(config.record_after_death) {}

GameSetup RunGames::SetupFor(std::uint64_t ticket) const {
  Rng rng = Rng(seed_).Split(ticket);
  GameSetup setup{.settings = settings_, .start = start_, .seats = {}, .seed = 0};
  const std::size_t index = DrawLineup(rng);
  const Lineup& lineup = table_.lineups[index];
  const int turn = static_cast<int>(rng.Below(static_cast<std::uint32_t>(lineup.seat_count)));
  for (int role = 0; role < lineup.seat_count; ++role) {
    setup.seats[(role + turn) % lineup.seat_count] = SeatOf(lineup, role);
  }
  setup.seed = rng.Next();
  setup.lineup = static_cast<std::uint8_t>(index);
  setup.to_the_end = to_the_end_;
  return setup;
}

std::size_t RunGames::DrawLineup(Rng& rng) const {
  double total = 0;
  for (const Lineup& lineup : table_.lineups) total += lineup.share;
  double left = rng.Uniform() * total;
  std::size_t index = 0;
  while (index + 1 < table_.lineups.size() && (left -= table_.lineups[index].share) >= 0) ++index;
  return index;
}

// Of an exam the first player is measured, and nobody teaches.
Seat RunGames::SeatOf(const Lineup& lineup, int role) const {
  const int index = lineup.seats[role];
  const Player& player = table_.players[index];
  const bool teaches = !lineup.exam && player.teaches != Teaches::kNothing;
  return {.searches = player.agent.kind != AgentSpec::Kind::kRuleBased,
          .policy = player.agent.policy,
          .teaches = teaches ? player.teaches : Teaches::kNothing,
          .measured = lineup.exam ? index == lineup.seats[0] : teaches,
          .player = static_cast<std::uint8_t>(index)};
}

}  // namespace powderkeg

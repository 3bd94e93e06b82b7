#include "common/record/game_setup.h"

#include <cstddef>

#include "common/base/rng.h"

namespace powderkeg {
RunGames::RunGames(const SelfPlayConfig& config)
    : settings_(GameOf(config)),
      start_{.generator = config.board_generator, .corners = config.corners},
      who_(ResolvePlayers(config)),
      seed_(config.seed),
      to_the_end_(config.record_after_death) {}

GameSetup RunGames::SetupFor(std::uint64_t ticket) const {
  Rng rng = Rng(seed_).Split(ticket);
  GameSetup setup{.settings = settings_, .start = start_, .seats = {}, .seed = 0};
  const std::size_t index = DrawLineup(rng);
  const Lineup& lineup = who_.lineups[index];
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
  for (const Lineup& lineup : who_.lineups) total += lineup.share;
  double left = rng.Uniform() * total;
  std::size_t index = 0;
  while (index + 1 < who_.lineups.size() && (left -= who_.lineups[index].share) >= 0) ++index;
  return index;
}

// Of an exam the first player is measured, and nobody teaches.
Seat RunGames::SeatOf(const Lineup& lineup, int role) const {
  const int index = lineup.seats[role];
  const Player& player = who_.players[index];
  const bool teaches = !lineup.exam && player.teaches != Teaches::kNothing;
  return {.searches = player.agent.kind != AgentSpec::Kind::kRuleBased,
          .policy = player.agent.policy,
          .teaches = teaches ? player.teaches : Teaches::kNothing,
          .measured = lineup.exam ? index == lineup.seats[0] : teaches,
          .player = static_cast<std::uint8_t>(index)};
}

}  // namespace powderkeg

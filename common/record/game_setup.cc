#include "common/record/game_setup.h"

#include <cstddef>

#include "common/base/rng.h"
#include "common/config/players.h"

namespace powderkeg {

GameSetup SetupFor(const SelfPlayConfig& config, std::uint64_t ticket) {
  const Players who = ResolvePlayers(config);
  const Lineup& lineup = who.lineups.front();
  GameSetup setup{.settings = GameOf(config),
                  .start = {.generator = config.board_generator, .corners = config.corners},
                  .seats = {},
                  .seed = 0};
  Rng rng = Rng(config.seed).Split(ticket);
  const auto seats = static_cast<std::size_t>(lineup.seat_count);
  const std::size_t searching = rng.Below(static_cast<std::uint32_t>(seats));
  for (std::size_t i = 1; i < seats; ++i) {
    const AgentSpec& agent = who.players[static_cast<std::size_t>(lineup.seats[i])].agent;
    setup.seats[(searching + i) % seats].policy = agent.policy;
  }
  setup.seats[searching].searches = true;
  setup.seed = rng.Next();
  return setup;
}

}  // namespace powderkeg

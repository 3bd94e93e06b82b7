#include "common/record/game_setup.h"

#include <cstddef>
#include <optional>

#include "common/base/check.h"
#include "common/base/rng.h"
#include "common/policies/policy.h"
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

PolicyKind PolicyNamed(std::string_view name) {
  const std::optional<PolicyKind> kind = PolicyKindFor(name);
  if (!kind) {
    throw Error(StrCat("opponent \"", name,
                       "\" is unknown; expected idle, random, harmless, "
                       "simple_unbiased or official_simple"));
  }
  return *kind;
}

StartSettings StartOf(const SelfPlayConfig& config) {
  return {
      .generator = config.board_generator == "uniform" ? BoardGenerator::kUniform
                                                       : BoardGenerator::kOfficial,
      .corners = config.corners == "permuted" ? StartCorners::kPermuted : StartCorners::kOfficial};
}

}  // namespace

GameSetup SetupFor(const SelfPlayConfig& config, std::uint64_t ticket) {
  constexpr std::size_t kDuelists = 2;  // one-against-one is played by agents 0 and 1
  GameSetup setup{.settings = SettingsOf(config), .start = StartOf(config), .seats = {}, .seed = 0};
  Rng rng = Rng(config.seed).Split(ticket);
  const std::size_t players = setup.settings.mode == Mode::kOneVsOne ? kDuelists : kAgentCount;
  const std::size_t searching = rng.Below(static_cast<std::uint32_t>(players));
  for (std::size_t i = 1; i < players; ++i) {
    setup.seats[(searching + i) % players].policy = PolicyNamed(config.opponents[i - 1]);
  }
  setup.seats[searching].searches = true;
  setup.seed = rng.Next();
  return setup;
}

}  // namespace powderkeg

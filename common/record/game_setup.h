#pragma once

// Tickets become games: nobody who plays a game chooses its board or its players.

#include <cstdint>

#include "common/config/players.h"
#include "common/config/run_config.h"
#include "common/record/game_record.h"

namespace powderkeg {

// Weights of a file (PlayerSpec::Weights::kFile) have this version, by the index of their player.
inline constexpr std::uint32_t kFirstFileVersion = std::uint32_t{1} << 31;
[[nodiscard]] constexpr std::uint32_t FileVersion(std::size_t player) {
  return kFirstFileVersion + static_cast<std::uint32_t>(player);
}

// The games of a run. Equal settings give equal games on every machine. Immutable.
class RunGames {
 public:
  // Throws Error if the environment, a player or a line-up is unknown or does not fit.
  explicit RunGames(const SelfPlayConfig& config);

  // The game of a ticket: its line-up (by the shares), who sits where (the line-up turned by a
  // random number of seats, so that neighbours and mates stay such) and its seed are drawn from the
  // run's seed and the ticket.
  [[nodiscard]] GameSetup SetupFor(std::uint64_t ticket) const;

  // Of every game.
  [[nodiscard]] const GameSettings& settings() const { return settings_; }
  // Seat::player is the index here, GameSetup::lineup there.
  [[nodiscard]] const std::vector<Player>& players() const { return who_.players; }
  [[nodiscard]] const std::vector<Lineup>& lineups() const { return who_.lineups; }

 private:
  [[nodiscard]] std::size_t DrawLineup(Rng& rng) const;
  [[nodiscard]] Seat SeatOf(const Lineup& lineup, int role) const;

  GameSettings settings_;
  StartSettings start_;
  Players who_;
  std::uint64_t seed_;
  bool to_the_end_;
};

}  // namespace powderkeg

#pragma once

// Tickets become games: nobody who plays a game chooses its board.

#include <cstdint>
#include <string_view>

#include "common/config/run_config.h"
#include "common/record/game_record.h"

namespace powderkeg {

// The game of a ticket: its seed and the searching seat are drawn from the run's seed and the
// ticket; the configured policies sit in the seats after it. Equal arguments give equal setups on
// every machine. Throws Error if the environment or a policy is unknown.
[[nodiscard]] GameSetup SetupFor(const SelfPlayConfig& config, std::uint64_t ticket);

}  // namespace powderkeg

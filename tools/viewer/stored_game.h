#pragma once

// A game to look at, whoever stored it: every position, move, reward and what the search found.

#include <array>
#include <string>
#include <vector>

#include "common/record/game_record.h"
#include "common/recorded/recorded_game.h"

namespace powderkeg {

struct StoredGame {
  RecordedGame game;
  // Who plays: "search", "simple_unbiased", ...; empty where it is not stored.
  std::array<std::string, kAgentCount> players;
  std::array<Track, kAgentCount> tracks;  // what the searches found; none if not stored
};

// Plays a record again, observations included where the official recorder writes them (team modes:
// at the start and after every fifth step). Throws Error with the reason if Verify refuses it.
[[nodiscard]] StoredGame StoredGameFrom(const GameRecord& record);

// The position after `step` steps, 0..game.steps.size().
[[nodiscard]] const State& PositionAfter(const RecordedGame& game, int step);

}  // namespace powderkeg

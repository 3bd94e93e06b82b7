#pragma once

// Matches: the same agents over many games, on all cores.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "actors/play/factory.h"
#include "actors/play/game.h"
#include "actors/play/game_loop.h"
#include "common/base/stats.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/generate.h"

namespace powderkeg {

// Who plays: role r sits in seat (r + number of the game) mod the number of seats, so that everyone
// plays every seat and neighbours stay neighbours. In team modes roles 0 and 2 are mates. Roles
// without a seat (one against one) are ignored.
using Lineup = std::array<AgentDescription, kAgentCount>;

struct MatchSettings {
  GameSettings game = {};
  StartSettings start{BoardGenerator::kOfficial, StartCorners::kPermuted};
  std::uint64_t seed = 1;  // of the boards and of everybody's choices
  int games = 100;
  int threads = 1;
  int games_in_flight = 16;  // per thread
};

// Arrays are indexed by role.
struct PlayedGame {
  int number = 0;          // from 0
  std::uint64_t seed = 0;  // GameSetup::seed
  int steps = 0;
  AgentId seat = 0;                                 // of role 0
  std::array<std::int8_t, kAgentCount> outcomes{};  // +1 win, 0 tie, -1 loss
  std::array<SeatStatistics, kAgentCount> statistics{};
};

struct Match {
  std::vector<PlayedGame> games;  // by number
  LoopMetrics metrics;            // of all threads
  double seconds = 0;             // wall time
  double thread_seconds = 0;      // of all threads together
};

// The setup of game `number`; depends on the seed of the match, not on the agents' strength.
[[nodiscard]] GameSetup SetupOf(const MatchSettings& settings, const Lineup& lineup, int number);

// Plays the match; every thread has a game loop and evaluators of its own. `on_game` is called for
// each game as it ends, one call at a time, from any thread. With the uniform evaluator the games
// depend on nothing but the line-up and the settings other than threads and games_in_flight.
// Throws Error if a model cannot be loaded.
[[nodiscard]] Match PlayMatch(const Lineup& lineup, const MatchSettings& settings,
                              const ModelLoader& loader,
                              const std::function<void(const PlayedGame&)>& on_game);

}  // namespace powderkeg

#pragma once

// Matches: the same agents over many games, on all cores.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "actors/play/factory.h"
#include "actors/play/game.h"
#include "actors/play/game_loop.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/generate.h"

namespace powderkeg {

// Who plays: role r sits in seat (r + number of the game) mod the number of seats, so that everyone
// plays every seat and neighbours stay neighbours. In team modes roles 0 and 2 are mates. Roles
// without a seat (one against one) are ignored. Role 0 is the agent that is measured.
using MatchLineup = std::array<AgentSpec, kAgentCount>;

struct MatchSettings {
  GameSettings game = {};
  StartSettings start{BoardGenerator::kOfficial, StartCorners::kPermuted};
  std::uint64_t seed = 1;  // of the boards and of everybody's choices
  int games = 100;         // at most
  // One thread and one game in flight where an agent is a server.
  int threads = 1;
  int games_in_flight = 0;  // per thread; 0: 16 where an agent has a model, else 1
  // Where the position is written that a network had no number for.
  std::string position_file = "arena-position.txt";
};

// Arrays are indexed by role.
struct PlayedGame {
  int number = 0;          // from 0
  std::uint64_t seed = 0;  // GameSetup::seed
  int steps = 0;
  AgentId seat = 0;                                 // of role 0
  std::array<std::int8_t, kAgentCount> outcomes{};  // official: +1 win, 0 tie, -1 loss
  std::array<bool, kAgentCount> died{};             // dead at the end
  GameStatistics statistics{};
};

struct Match {
  std::vector<PlayedGame> games;  // by number
  std::vector<int> roles = {0};   // of the measured agent: 0, with itself as mate 0 and 2
  // Speed; games that were cut off when the match was decided are included.
  LoopMetrics metrics;            // of all threads
  double seconds = 0;             // wall time
  double thread_seconds = 0;      // of all threads together
  std::uint64_t timed_moves = 0;  // of the measured agent, in that time
};

// The setup of game `number`; depends on the seed of the match, not on the agents' strength.
[[nodiscard]] GameSetup SetupOf(const MatchSettings& settings, const MatchLineup& lineup,
                                int number);

// What the search trees of the match take, once everybody has played every seat.
[[nodiscard]] std::size_t TreeBytes(const MatchLineup& lineup, const MatchSettings& settings);

// Who looks on. Called one call at a time, from any thread.
struct MatchObserver {
  // Each game as it ends.
  std::function<void(const PlayedGame&)> on_game;
  // If set: each game in the order of numbers, once all before have ended too, so that short games
  // do not count first. True: the match ends with this game; later ones are dropped.
  std::function<bool(const PlayedGame&)> is_enough;
};

class MatchThread;

// Plays a match in one or several goes. Every thread has a game loop and evaluators of its own,
// which stay from go to go. With the uniform evaluator the games depend on nothing but the line-up
// and the settings other than threads and games_in_flight. One thread.
class MatchPlayer {
 public:
  // Throws Error if a model cannot be loaded.
  MatchPlayer(const MatchLineup& lineup, const MatchSettings& settings, const ModelLoader& loader);
  ~MatchPlayer();

  // Plays the next `games` games, or fewer if the observer has enough. Throws Error, and the match
  // is over, if a network answers with something that is not a number: the message names the agent
  // and the file that holds the position (board_text.h).
  void Play(int games, const MatchObserver& observer);
  // Forgets all games but the first ones.
  void KeepFirst(std::size_t games);

  [[nodiscard]] const Match& match() const { return match_; }

 private:
  MatchLineup lineup_;
  MatchSettings settings_;
  std::vector<std::unique_ptr<MatchThread>> threads_;
  Match match_;
};

}  // namespace powderkeg

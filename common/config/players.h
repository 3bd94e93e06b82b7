#pragma once

// Who plays a run's games: players, and line-ups that fill the seats with them.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/config/agent_spec.h"
#include "common/pommerman/game_settings.h"

namespace powderkeg {

// Who decides for a seat, as written: self_play.player { ... }.
struct PlayerSpec {
  enum class Weights : std::uint8_t {
    kNone,    // the uniform evaluator
    kNewest,  // of the run
    kPast,    // an earlier version of the run's, drawn for every game
    kFile,    // weights_file
  };
  enum class Teaches : std::uint8_t {
    kNothing,
    kSearch,  // what its search found
    kMoves,   // what it did: a demonstration
  };

  std::string name{};
  std::string agent = "search";      // a search's options change self_play.search
  std::optional<Weights> weights{};  // none: newest for agents with a network
  std::string weights_file{};        // of kFile
  Teaches teaches = Teaches::kNothing;

  friend bool operator==(const PlayerSpec&, const PlayerSpec&) = default;
};
[[nodiscard]] Names NamesOf(PlayerSpec::Teaches);

// Four seats (two in one-against-one), rotated by the ticket, as written: self_play.lineup { ... }.
// In team modes seats 0 and 2 are mates.
struct LineupSpec {
  double share = 1;   // of the tickets, relative to the other line-ups'
  bool exam = false;  // teaches nothing: the yardstick
  Words seats{};      // names of players, of policies or pessimist

  friend bool operator==(const LineupSpec&, const LineupSpec&) = default;
};

[[nodiscard]] OptionTable<PlayerSpec> PlayerOptions();
[[nodiscard]] OptionTable<LineupSpec> LineupOptions();

// A player with everything that was left open.
struct Player {
  std::string name{};
  AgentSpec agent{};
  PlayerSpec::Weights weights = PlayerSpec::Weights::kNone;
  std::string weights_file{};
  PlayerSpec::Teaches teaches = PlayerSpec::Teaches::kNothing;

  friend bool operator==(const Player&, const Player&) = default;
};

struct Lineup {
  std::string name{};  // who plays, such as "me + 3 simple_unbiased"
  double share = 0;    // of all tickets; those of all line-ups sum to 1
  bool exam = false;
  std::array<int, kAgentCount> seats{};  // numbers of players, [0, seat_count)
  int seat_count = kAgentCount;

  friend bool operator==(const Lineup&, const Lineup&) = default;
};

struct Players {
  std::vector<Player> players;  // those of the settings in their order, then scripts
  std::vector<Lineup> lineups;

  friend bool operator==(const Players&, const Players&) = default;
};

struct SelfPlayConfig;

// Where no player is given: "me", the run's search, which learns. Where no line-up is given: the
// first player and config.opponents in 95 % of the games, and as an exam in the rest. Throws Error
// if they are too few, or given beside line-ups, or the environment is unknown.
void FillPlayers(SelfPlayConfig& config);

// Who plays under these settings. Throws Error with what is wrong: an unknown or doubled name, a
// wrong number of seats, shares that sum to 0, weights or lessons that the agent cannot have, or
// nobody who teaches; and for an unknown environment.
[[nodiscard]] Players ResolvePlayers(const SelfPlayConfig& config);

}  // namespace powderkeg

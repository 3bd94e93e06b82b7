#pragma once

// From game records to what training reads: what the teaching seats knew, did and reached.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/base/stats.h"
#include "common/pommerman/state.h"
#include "common/record/game_record.h"

namespace powderkeg {

struct RecordedGame;

// One decision as a training example. Planes are encoded when a batch is built.
struct Sample {
  State state;                                     // as the viewer's Belief held it
  std::array<std::uint16_t, kActionCount> visits;  // policy target; all 0: none
  std::uint8_t viewer;                             // the agent that decided
  std::int8_t outcome;                             // +1 win, 0 tie, -1 loss of the viewer
  std::uint16_t end_step;                          // when the record of the game ends
  bool searched;                                   // false: a demonstration
  // What viewer + 1, + 2, + 3 (mod 4) did in this step; nothing (kStop) of the dead.
  std::array<Action, kAgentCount - 1> others;
  float search_value;  // of the search's root, the viewer's view; 0 of demonstrations
};

// How the measured seats of some games fared.
struct PlaySummary {
  std::uint64_t games = 0;
  std::uint64_t decisions = 0;
  MatchScore score;  // one official result per measured side and game
  std::uint64_t steps = 0;
  std::array<std::uint64_t, kActionCount> actions{};  // in the samples
  // Sum over the games of the newest weights in play, for the mean; 0 (no network) counts as 1.
  std::uint64_t weights_versions = 0;

  PlaySummary& operator+=(const PlaySummary& other);
};

// Who sat somewhere and how far it came.
struct Finish {
  std::uint8_t player = 0;  // index among the players of the run
  std::uint32_t weights_version = 0;
  AgentId mate = -1;         // in team modes
  std::uint16_t lasted = 0;  // steps that it was alive to play
  bool counts = false;       // of its side, its result is the one that is measured
  std::int8_t outcome = 0;   // OutcomeFor
};

// Who came how far.
struct GameResult {
  std::array<Finish, kAgentCount> finishes;
  Outcome outcome;
  std::uint8_t lineup = 0;  // index among the line-ups of the run
};

// What one game has to teach.
struct Lessons {
  std::uint64_t ticket = 0;
  std::vector<Sample> samples;       // ascending by step, then agent
  PlaySummary play;                  // of this game, where somebody taught
  PlaySummary exam;                  // where nobody did
  std::optional<GameResult> result;  // none: nobody of the run played
};

// The games of one iteration. A value; one thread.
struct DataSet {
  std::vector<Sample> samples;   // in the order in which the games were added
  std::vector<Sample> held_out;  // never trained on
  PlaySummary play;
  PlaySummary exam;
  std::vector<GameResult> results;  // in the same order

  enum class Part : std::uint8_t { kTraining, kHeldOut };
  void Add(Lessons&& lessons, Part part);
};

// Re-plays the game and has every teaching seat's Belief look on. z is the official result, but -1
// for whoever was dead before the last step of a free-for-all that ends in a tie. Returns the
// reason for refusal if the record does not verify. Never throws, safe on records from peers.
[[nodiscard]] std::variant<Lessons, std::string> MakeLessons(const GameRecord& game);

// The same of a game that was recorded elsewhere: every agent teaches what it did, but of a game
// that was cut off only who had lost by then. Requires game.Known().
[[nodiscard]] std::variant<Lessons, std::string> MakeLessons(const RecordedGame& game,
                                                             std::uint64_t ticket);

}  // namespace powderkeg

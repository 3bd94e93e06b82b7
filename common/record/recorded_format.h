#pragma once

// Games recorded in the official environment, one JSON object per line (format version 1), and
// their replay: the proof that Step plays by the official rules.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/pommerman/game_settings.h"
#include "common/pommerman/observation.h"
#include "common/pommerman/state.h"
#include "common/pommerman/step.h"

namespace powderkeg {

// An official observation: what Observation holds, and what it leaves to the settings.
struct RecordedObservation {
  Observation observation;
  CellValue team_mate = CellValue::kAgentDummy;
  std::vector<CellValue> enemies;
  int game_type = 0;
  std::string environment;  // the official class, e.g. "pommerman.envs.v0:Pomme"

  friend bool operator==(const RecordedObservation&, const RecordedObservation&) = default;
};

// By agent id, of those that play.
using RecordedObservations = std::vector<RecordedObservation>;

struct RecordedStep {
  JointAction actions{};
  std::array<Message, kAgentCount> messages{};  // the words sent along
  State state;                                  // after the step and, if there was one, a collapse
  std::array<std::int8_t, kAgentCount> rewards{};
  bool done = false;
  std::optional<RecordedObservations> observations;  // before a collapse
};

struct RecordedGame {
  std::string id;
  std::string environment;  // the official id
  std::string mode;  // as recorded: ffa, team, radio or one_vs_one; others cannot be replayed
  std::string tag;
  GameSettings settings;
  State start;
  std::optional<RecordedObservations> observations;  // of the start
  std::vector<RecordedStep> steps;
  // kIncomplete where the recorder cut the game off.
  Result result = Result::kIncomplete;
  std::uint8_t winners = 0;  // bit i: agent i

  // A game of another mode is read as its id and mode alone.
  [[nodiscard]] bool Known() const {
    return mode == "ffa" || mode == "team" || mode == "radio" || mode == "one_vs_one";
  }
};

// Gives the next line; false at the end.
using LineSource = std::function<bool(std::string& line)>;

// Reads recorded games one after the other. One thread.
class RecordedGameReader {
 public:
  // A .jsonl or .jsonl.gz file. Throws Error if it cannot be opened.
  explicit RecordedGameReader(const std::string& path);
  // Lines from anywhere; `name` stands for the file in messages.
  RecordedGameReader(std::string name, LineSource lines);

  // The next whole game; false at the end. Throws Error "<file>:<line>: <reason>" on what is not
  // a recorded game.
  bool Next(RecordedGame& game);

 private:
  std::string name_;
  LineSource lines_;
  int line_number_ = 0;
};

// A recorded state as JSON text ({"n":..,"b":..,"ag":..,"bo":..,"fl":..,"it":..}) and back. The
// board text "b" is derived from the position, and on reading must agree with it. Messages are not
// part of a recorded state. Throws Error on malformed text. A small board, and the two agents on
// it, are recorded alone: beyond are rigid walls.
[[nodiscard]] State StateFromRecorded(std::string_view json);
[[nodiscard]] std::string RecordedFrom(const GameSettings& settings, const State& state);

// A recorded observation as JSON text and back. Throws Error on malformed text. `self` is not part
// of it: an agent finds itself on the board only as long as it lives.
[[nodiscard]] RecordedObservation ObservationFromRecorded(std::string_view json, AgentId self);

// A line of start_boards.jsonl: board and hidden items, everybody alive with what agents start
// with. Throws Error on malformed text.
[[nodiscard]] State StartBoardFromRecorded(std::string_view json);

// What the official environment shows an agent.
[[nodiscard]] RecordedObservation OfficialObservation(const GameSettings& settings,
                                                      const State& state, AgentId self);

// Plays the recorded actions from the recorded start. Returns one text for each difference in a
// state, a reward, the end, the result or an observation; none if all is equal. Goes on from the
// recorded state after a difference. Requires game.Known().
[[nodiscard]] std::vector<std::string> ReplayDifferences(const RecordedGame& game);

}  // namespace powderkeg

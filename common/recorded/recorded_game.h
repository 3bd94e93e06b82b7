#pragma once

// Games recorded in the official environment, one JSON object per line (format version 1,
// docs/spec/recorded_format.md).

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

// A board is text of 121 of these digits, or 64 of a board of 8 x 8, row by row.
inline constexpr std::string_view kBoardDigits = "0123456789abcdefghijklmnopqrstuvwxyz";
// The numbers that such a text stands for; `beyond` a small board. Throws Error on any other text.
[[nodiscard]] std::array<std::uint8_t, kCellCount> BoardNumbers(std::string_view digits,
                                                                CellValue beyond = {});

// nullopt for a mode that cannot be replayed: all but ffa, team, radio
// and one_vs_one.
[[nodiscard]] std::optional<Mode> RecordedModeFor(std::string_view name);

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
  std::string mode;         // as recorded
  std::string tag;
  GameSettings settings;
  State start;
  std::optional<RecordedObservations> observations;  // of the start
  std::vector<RecordedStep> steps;
  // kIncomplete where the recorder cut the game off.
  Result result = Result::kIncomplete;
  std::uint8_t winners = 0;  // bit i: agent i

  // A game of another mode is read as its id and mode alone.
  [[nodiscard]] bool Known() const { return RecordedModeFor(mode).has_value(); }
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

}  // namespace powderkeg

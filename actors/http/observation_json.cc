#include "actors/http/observation_json.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

#include "actors/http/json_reader.h"

namespace powderkeg {
namespace {

constexpr int kAgent0 = static_cast<int>(CellValue::kAgent0);
constexpr int kDummy = static_cast<int>(CellValue::kAgentDummy);
constexpr int kMaxBlastStrength = 10;
constexpr int kFirstBlastStrength = 2;
constexpr int kFirstAmmo = 1;
constexpr int kFreshFlameLife = 3;
constexpr int kMaxWord = 255;  // the environment does not check words; the docs say 1..8

template <typename Value>
using Grid = std::array<Value, kCellCount>;

std::string CellText(Cell cell) { return StrCat("[", RowOf(cell), "][", ColumnOf(cell), "]"); }

// The value that the body holds under `key`, as JSON or as a text of JSON.
Json Decoded(JsonReader& reader, const Json& body, std::string_view key) {
  const Json& value = reader.Member(body, key);
  return value.is_string() ? reader.Parse(value.get<std::string>(), key, kMaxJsonDepth) : value;
}

template <typename Value>
Parsed<Value> Finished(JsonReader& reader, Value value) {
  if (reader.ok()) return value;
  return Refusal{*reader.refusal()};
}

// --- Fields -------------------------------------------------------------------------------------

// An observation while it is read.
struct Reading {
  JsonReader& reader;
  const Json& object;
  ActionRequest request{};

  // Null, and noted, if it is missing.
  const Json* Find(std::string_view key) {
    const Json* const found = JsonReader::Find(object, key);
    if (found == nullptr)
      request.believed += (request.believed.empty() ? "" : ", ") + std::string(key);
    return found;
  }
  int Number(std::string_view key, int minimum, int maximum, int believed) {
    const Json* const value = Find(key);
    return value == nullptr ? believed : reader.Nearest(*value, key, minimum, maximum);
  }
};

// Calls `read(value, name)` for each cell of the size x size numbers in the top left part.
template <typename Read>
void ReadGrid(JsonReader& reader, const Json& grid, std::string_view key, int size, Read&& read) {
  const auto length = static_cast<std::size_t>(size);
  const Json& rows = reader.List(grid, key, length);
  for (int row = 0; row < size && reader.ok(); ++row) {
    const std::string name = StrCat(key, "[", row, "]");
    const Json& values =
        reader.List(JsonReader::Element(rows, static_cast<std::size_t>(row)), name, length);
    for (int column = 0; column < size && reader.ok(); ++column) {
      read(CellAt(row, column), JsonReader::Element(values, static_cast<std::size_t>(column)),
           name);
    }
  }
}

void ReadBoard(Reading& reading, int size, Grid<CellValue>& board) {
  board.fill(CellValue::kRigid);  // beyond a smaller board
  JsonReader& reader = reading.reader;
  ReadGrid(reader, reader.Member(reading.object, "board"), "board", size,
           [&](Cell cell, const Json& value, const std::string& name) {
             const int most = kAgent0 + kAgentCount - 1;
             board[cell] = static_cast<CellValue>(reader.Integer(value, name, 0, most));
           });
}

// What is missing is 0 everywhere.
template <typename Value>
void ReadNumbers(Reading& reading, std::string_view key, int size, int maximum,
                 Grid<Value>& cells) {
  const Json* const grid = reading.Find(key);
  if (grid == nullptr) return;
  ReadGrid(reading.reader, *grid, key, size,
           [&](Cell cell, const Json& value, const std::string& name) {
             cells[cell] = static_cast<Value>(reading.reader.Nearest(value, name, 0, maximum));
           });
}

void ReadGrids(Reading& reading, int size) {
  Observation& observation = reading.request.observation;
  ReadBoard(reading, size, observation.board);
  ReadNumbers(reading, "bomb_blast_strength", size, kMaxBlastStrength,
              observation.bomb_blast_strength);
  ReadNumbers(reading, "bomb_life", size, kFreshBombLife, observation.bomb_life);
  ReadNumbers(reading, "bomb_moving_direction", size, static_cast<int>(Direction::kRight),
              observation.bomb_moving_direction);
  ReadNumbers(reading, "flame_life", size, kFreshFlameLife, observation.flame_life);
}

void ReadAlive(Reading& reading) {
  Observation& observation = reading.request.observation;
  const Json* const alive = reading.Find("alive");
  if (alive == nullptr) return observation.alive.fill(true);
  reading.reader.Require(alive->is_array() && alive->size() <= kAgentCount,
                         "alive is no list of at most 4 agents");
  for (std::size_t i = 0; i < alive->size() && reading.reader.ok(); ++i) {
    const int value =
        reading.reader.Integer((*alive)[i], "alive", kAgent0, kAgent0 + kAgentCount - 1);
    observation.alive[value - kAgent0] = true;
  }
}

void ReadPosition(Reading& reading, int size) {
  JsonReader& reader = reading.reader;
  const Json& position = reader.List(reader.Member(reading.object, "position"), "position", 2);
  const int row = reader.Integer(JsonReader::Element(position, 0), "position[0]", 0, size - 1);
  const int column = reader.Integer(JsonReader::Element(position, 1), "position[1]", 0, size - 1);
  reading.request.observation.position = static_cast<std::uint8_t>(CellAt(row, column));
}

void ReadStatistics(Reading& reading) {
  Observation& observation = reading.request.observation;
  observation.blast_strength = static_cast<std::uint8_t>(
      reading.Number("blast_strength", 1, kMaxBlastStrength, kFirstBlastStrength));
  observation.ammo = static_cast<std::uint8_t>(reading.Number("ammo", 0, kMaxAmmo, kFirstAmmo));
  const Json* const can_kick = reading.Find("can_kick");
  observation.can_kick = can_kick != nullptr && reading.reader.Boolean(*can_kick, "can_kick");
}

void ReadMessage(Reading& reading) {
  const Json* const message = reading.Find("message");
  if (message == nullptr) return;
  const Json& words = reading.reader.List(*message, "message", 2);
  for (std::size_t i = 0; i < 2; ++i) {
    reading.request.observation.message[i] = static_cast<std::uint8_t>(
        reading.reader.Nearest(JsonReader::Element(words, i), "message", 0, kMaxWord));
  }
}

void ReadStep(Reading& reading) {
  constexpr int kNoLastStep = UINT16_MAX;
  ActionRequest& request = reading.request;
  request.step_known = JsonReader::Find(reading.object, "step_count") != nullptr;
  const int step = reading.Number("step_count", 0, kNoLastStep - 1, 0);
  if (step >= request.settings.max_steps) request.settings.max_steps = kNoLastStep;
  request.observation.step = static_cast<std::uint16_t>(step);
}

// --- What the fields say together ---------------------------------------------------------------

// Who observes is not sent: it is the agent that stands on `position`.
void IdentifySelf(JsonReader& reader, Observation& observation) {
  const int shown = static_cast<int>(observation.board[observation.position]);
  reader.Require(shown >= kAgent0, "board", CellText(observation.position), " is ", shown,
                 ", expected the living agent whose position this is");
  if (reader.ok()) observation.self = shown - kAgent0;
}

// Whoever is shown lives, and where everything is shown nobody else.
void MendAgents(JsonReader& reader, bool fog, Observation& observation) {
  std::array<int, kAgentCount> shown{};
  for (Cell cell = 0; cell < kCellCount; ++cell) {
    const int value = static_cast<int>(observation.board[cell]);
    reader.Require(value != kDummy, "board", CellText(cell), " is 9, which is never on the board");
    if (value >= kAgent0) ++shown[value - kAgent0];
  }
  for (std::size_t i = 0; i < kAgentCount; ++i) {
    reader.Require(shown[i] <= 1, "agent ", kAgent0 + static_cast<int>(i), " is shown ", shown[i],
                   " times on the board");
    observation.alive[i] = shown[i] > 0 || (fog && observation.alive[i]);
  }
}

// Bombs are where the board shows one, or an agent that may stand on one.
void MendBombs(JsonReader& reader, Observation& observation) {
  int bombs = 0;
  for (std::size_t i = 0; i < kCellCount; ++i) {
    const CellValue value = observation.board[i];
    std::uint8_t& life = observation.bomb_life[i];
    std::uint8_t& strength = observation.bomb_blast_strength[i];
    const bool bomb =
        value == CellValue::kBomb || (value >= CellValue::kAgent0 && (life > 0 || strength > 0));
    if (!bomb) {
      life = strength = 0;
      observation.bomb_moving_direction[i] = Direction::kNone;
      continue;
    }
    if (life == 0) life = kFreshBombLife;
    if (strength == 0) strength = kFirstBlastStrength;
    ++bombs;
  }
  reader.Require(bombs <= kMaxBombs, bombs, " bombs, expected at most ", kMaxBombs);
}

void MendFlames(Observation& observation) {
  for (std::size_t i = 0; i < kCellCount; ++i) {
    std::uint8_t& life = observation.flame_life[i];
    if (observation.board[i] != CellValue::kFlames)
      life = 0;
    else if (life == 0)
      life = kFreshFlameLife;
  }
}

// How far the agent sees; 0: there is no fog.
int ViewRadius(const Observation& observation) {
  int radius = 0;
  bool fog = false;
  for (Cell cell = 0; cell < kCellCount; ++cell) {
    if (observation.board[cell] == CellValue::kFog) {
      fog = true;
    } else {
      radius = std::max({radius, std::abs(RowOf(cell) - RowOf(observation.position)),
                         std::abs(ColumnOf(cell) - ColumnOf(observation.position))});
    }
  }
  return fog ? std::max(radius, 1) : 0;
}

// --- The environment ----------------------------------------------------------------------------

// The registered environment that shows such observations.
std::string_view EnvironmentOf(Mode mode, bool fog, bool collapses) {
  switch (mode) {
    case Mode::kFreeForAll: return collapses ? "PommeFFA-v1" : "PommeFFACompetition-v0";
    case Mode::kTeam:
      if (!fog) return "PommeTeam-v0";
      return collapses ? "PommeTeamCompetition-v1" : "PommeTeamCompetition-v0";
    case Mode::kTeamRadio: return "PommeRadioCompetition-v2";
    case Mode::kOneVsOne: return "OneVsOne-v0";
  }
  return "";
}

GameSettings SettingsOf(Mode mode, bool fog, std::string_view game_env) {
  const bool collapses = game_env.find(".v1:") != std::string_view::npos;
  const auto settings = GameSettingsFor(EnvironmentOf(mode, fog, collapses));
  CHECK(settings.has_value());
  return *settings;
}

void ReadObservation(Reading& reading) {
  JsonReader& reader = reading.reader;
  ActionRequest& request = reading.request;
  const auto mode = static_cast<Mode>(
      reader.Integer(reader.Member(reading.object, "game_type"), "game_type",
                     static_cast<int>(Mode::kFreeForAll), static_cast<int>(Mode::kOneVsOne)));
  const Json* const found = reading.Find("game_env");
  const std::string game_env =
      found != nullptr && found->is_string() ? found->get<std::string>() : "";
  const int size = SettingsOf(mode, /*fog=*/false, game_env).board_size;
  ReadGrids(reading, size);
  ReadAlive(reading);
  ReadPosition(reading, size);
  ReadStatistics(reading);
  if (mode == Mode::kTeamRadio) ReadMessage(reading);
  const int radius = ViewRadius(request.observation);
  request.settings = SettingsOf(mode, radius > 0, game_env);
  request.settings.view_radius = radius;
  ReadStep(reading);
}

void MendObservation(Reading& reading) {
  Observation& observation = reading.request.observation;
  IdentifySelf(reading.reader, observation);
  MendAgents(reading.reader, reading.request.settings.view_radius > 0, observation);
  MendBombs(reading.reader, observation);
  MendFlames(observation);
}

}  // namespace

Parsed<InitRequest> ParseInitRequest(std::string_view body) {
  JsonReader reader;
  const Json object = reader.Parse(body, "the body", kMaxJsonDepth);
  const int id = reader.Integer(Decoded(reader, object, "id"), "id", 0, kAgentCount - 1);
  const int mode =
      reader.Integer(Decoded(reader, object, "game_type"), "game_type",
                     static_cast<int>(Mode::kFreeForAll), static_cast<int>(Mode::kOneVsOne));
  return Finished(reader, InitRequest{.id = id, .mode = static_cast<Mode>(mode)});
}

Parsed<ActionRequest> ParseActionRequest(std::string_view body) {
  JsonReader reader;
  const Json outer = reader.Parse(body, "the body", kMaxJsonDepth);
  const Json object = Decoded(reader, outer, "obs");
  Reading reading{.reader = reader, .object = object};
  if (reader.ok()) ReadObservation(reading);
  if (reader.ok()) MendObservation(reading);
  return Finished(reader, std::move(reading.request));
}

Parsed<int> ParseEpisodeEnd(std::string_view body) {
  JsonReader reader;
  const Json object = reader.Parse(body, "the body", kMaxJsonDepth);
  return Finished(reader, reader.Integer(Decoded(reader, object, "reward"), "reward", -1, 1));
}

}  // namespace powderkeg

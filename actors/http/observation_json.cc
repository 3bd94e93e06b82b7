#include "actors/http/observation_json.h"

#include <array>
#include <string>
#include <utility>

#include "actors/http/json_reader.h"

namespace powderkeg {
namespace {

constexpr int kAgent0 = static_cast<int>(CellValue::kAgent0);
constexpr int kDummy = static_cast<int>(CellValue::kAgentDummy);
constexpr int kMaxBlastStrength = 10;
constexpr int kFreshFlameLife = 3;
constexpr int kMaxWord = 255;  // the environment does not check words; the docs say 1..8

template <typename Value>
using Grid = std::array<Value, kCellCount>;

std::string CellText(Cell cell) { return StrCat("[", RowOf(cell), "][", ColumnOf(cell), "]"); }

// The value that the body holds as text under `key`.
Json Decoded(JsonReader& reader, const Json& body, std::string_view key) {
  const std::string text = reader.Text(reader.Member(body, key), key);
  if (!reader.ok()) return nullptr;
  return reader.Parse(text, key, kMaxJsonDepth);
}

template <typename Value>
Parsed<Value> Finished(JsonReader& reader, Value value) {
  if (reader.ok()) return value;
  return Refusal{*reader.refusal()};
}

// --- Fields -------------------------------------------------------------------------------------

// Reads size x size numbers 0..maximum into the top left part of `cells`.
template <typename Value>
void ReadGrid(JsonReader& reader, const Json& object, std::string_view key, int size, int maximum,
              Grid<Value>& cells) {
  const auto length = static_cast<std::size_t>(size);
  const Json& rows = reader.List(reader.Member(object, key), key, length);
  for (int row = 0; row < size && reader.ok(); ++row) {
    const std::string name = StrCat(key, "[", row, "]");
    const Json& values =
        reader.List(JsonReader::Element(rows, static_cast<std::size_t>(row)), name, length);
    for (int column = 0; column < size && reader.ok(); ++column) {
      const Json& value = JsonReader::Element(values, static_cast<std::size_t>(column));
      cells[CellAt(row, column)] = static_cast<Value>(reader.Integer(value, name, 0, maximum));
    }
  }
}

void ReadGrids(JsonReader& reader, const Json& object, int size, Observation& observation) {
  observation.board.fill(CellValue::kRigid);  // beyond a smaller board
  ReadGrid(reader, object, "board", size, kAgent0 + kAgentCount - 1, observation.board);
  ReadGrid(reader, object, "bomb_blast_strength", size, kMaxBlastStrength,
           observation.bomb_blast_strength);
  ReadGrid(reader, object, "bomb_life", size, kFreshBombLife, observation.bomb_life);
  ReadGrid(reader, object, "bomb_moving_direction", size, static_cast<int>(Direction::kRight),
           observation.bomb_moving_direction);
  ReadGrid(reader, object, "flame_life", size, kFreshFlameLife, observation.flame_life);
}

void ReadAlive(JsonReader& reader, const Json& object, Observation& observation) {
  const Json& alive = reader.Member(object, "alive");
  reader.Require(alive.is_array() && alive.size() <= kAgentCount,
                 "alive is no list of at most 4 agents");
  for (std::size_t i = 0; i < alive.size() && reader.ok(); ++i) {
    const int value = reader.Integer(alive[i], "alive", kAgent0, kAgent0 + kAgentCount - 1);
    bool& living = observation.alive[value - kAgent0];
    reader.Require(!living, "alive names agent ", value, " twice");
    living = true;
  }
}

void ReadPosition(JsonReader& reader, const Json& object, int size, Observation& observation) {
  const Json& position = reader.List(reader.Member(object, "position"), "position", 2);
  const int row = reader.Integer(JsonReader::Element(position, 0), "position[0]", 0, size - 1);
  const int column = reader.Integer(JsonReader::Element(position, 1), "position[1]", 0, size - 1);
  observation.position = static_cast<std::uint8_t>(CellAt(row, column));
}

void ReadStatistics(JsonReader& reader, const Json& object, Observation& observation) {
  observation.blast_strength = static_cast<std::uint8_t>(reader.Integer(
      reader.Member(object, "blast_strength"), "blast_strength", 1, kMaxBlastStrength));
  observation.ammo =
      static_cast<std::uint8_t>(reader.Integer(reader.Member(object, "ammo"), "ammo", 0, kMaxAmmo));
  observation.can_kick = reader.Boolean(reader.Member(object, "can_kick"), "can_kick");
}

void ReadMessage(JsonReader& reader, const Json& object, Observation& observation) {
  const Json& words = reader.List(reader.Member(object, "message"), "message", 2);
  for (std::size_t i = 0; i < 2; ++i) {
    observation.message[i] = static_cast<std::uint8_t>(
        reader.Integer(JsonReader::Element(words, i), "message", 0, kMaxWord));
  }
}

// --- What the fields must say together ----------------------------------------------------------

// Who observes is not sent: it is the agent that stands on `position`.
void IdentifySelf(JsonReader& reader, Observation& observation) {
  const int shown = static_cast<int>(observation.board[observation.position]);
  reader.Require(shown >= kAgent0, "board", CellText(observation.position), " is ", shown,
                 ", expected the living agent whose position this is");
  if (reader.ok()) observation.self = shown - kAgent0;
}

void CheckAgents(JsonReader& reader, const Observation& observation, bool fog) {
  std::array<int, kAgentCount> shown{};
  for (Cell cell = 0; cell < kCellCount; ++cell) {
    const int value = static_cast<int>(observation.board[cell]);
    reader.Require(value != kDummy, "board", CellText(cell), " is 9, which is never on the board");
    if (value >= kAgent0) ++shown[value - kAgent0];
  }
  for (std::size_t i = 0; i < kAgentCount; ++i) {
    const int most = observation.alive[i] ? 1 : 0;
    const int least = fog ? 0 : most;
    reader.Require(shown[i] >= least && shown[i] <= most, "agent ", kAgent0 + static_cast<int>(i),
                   most == 1 ? " is alive" : " is dead", " and shown ", shown[i],
                   " times on the board");
  }
}

void CheckBombs(JsonReader& reader, const Observation& observation) {
  int bombs = 0;
  for (std::size_t i = 0; i < kCellCount; ++i) {
    const bool bomb = observation.bomb_life[i] > 0;
    const bool agrees = bomb == (observation.bomb_blast_strength[i] > 0) &&
                        (bomb || observation.bomb_moving_direction[i] == Direction::kNone);
    const CellValue value = observation.board[i];
    const bool shown =
        bomb ? value == CellValue::kBomb || value >= CellValue::kAgent0 : value != CellValue::kBomb;
    reader.Require(agrees && shown, "board, bomb_blast_strength, bomb_life and ",
                   "bomb_moving_direction disagree about a bomb on ",
                   CellText(static_cast<Cell>(i)));
    bombs += bomb ? 1 : 0;
  }
  reader.Require(bombs <= kMaxBombs, bombs, " bombs, expected at most ", kMaxBombs);
}

void CheckFlames(JsonReader& reader, const Observation& observation) {
  for (std::size_t i = 0; i < kCellCount; ++i) {
    reader.Require((observation.flame_life[i] > 0) == (observation.board[i] == CellValue::kFlames),
                   "board and flame_life disagree about flames on ",
                   CellText(static_cast<Cell>(i)));
  }
}

BitBoard FogOf(const Observation& observation) {
  BitBoard fog;
  for (std::size_t i = 0; i < kCellCount; ++i) {
    if (observation.board[i] == CellValue::kFog) fog.Add(static_cast<Cell>(i));
  }
  return fog;
}

// `teammate` and `enemies` follow from who plays what; the environment of one against one fills
// them as it would for teams.
void CheckSides(JsonReader& reader, const Json& object, const GameSettings& settings,
                AgentId self) {
  const int teammate = reader.Integer(reader.Member(object, "teammate"), "teammate", kDummy,
                                      kAgent0 + kAgentCount - 1);
  const Json& enemies = reader.List(reader.Member(object, "enemies"), "enemies", 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const int enemy = reader.Integer(JsonReader::Element(enemies, i), "enemies", kDummy,
                                     kAgent0 + kAgentCount - 1);
    reader.Require(enemy != kAgent0 + self, "enemies name agent ", enemy, " itself");
  }
  if (settings.mode == Mode::kOneVsOne) return;
  const AgentId mate = TeamMateOf(settings.mode, self);
  const int expected = mate < 0 ? kDummy : kAgent0 + mate;
  reader.Require(teammate == expected, "teammate is ", teammate, ", expected ", expected);
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

void CheckView(JsonReader& reader, const Observation& observation, const GameSettings& settings) {
  const BitBoard expected = ~VisibleCells(settings, observation.position);
  const BitBoard wrong = expected ^ FogOf(observation);
  reader.Require(wrong.Empty(), "fog is expected exactly on the cells farther than ",
                 settings.view_radius, " from the agent, which is wrong on ",
                 wrong.Any() ? CellText(wrong.First()) : "");
}

ActionRequest ReadObservation(JsonReader& reader, const Json& object) {
  ActionRequest request{};
  Observation& observation = request.observation;
  const auto mode = static_cast<Mode>(
      reader.Integer(reader.Member(object, "game_type"), "game_type",
                     static_cast<int>(Mode::kFreeForAll), static_cast<int>(Mode::kOneVsOne)));
  const std::string game_env = reader.Text(reader.Member(object, "game_env"), "game_env");
  const int size = SettingsOf(mode, /*fog=*/false, game_env).board_size;
  ReadGrids(reader, object, size, observation);
  ReadAlive(reader, object, observation);
  ReadPosition(reader, object, size, observation);
  ReadStatistics(reader, object, observation);
  if (mode == Mode::kTeamRadio) ReadMessage(reader, object, observation);
  request.settings = SettingsOf(mode, FogOf(observation).Any(), game_env);
  observation.step = static_cast<std::uint16_t>(reader.Integer(
      reader.Member(object, "step_count"), "step_count", 0, request.settings.max_steps));
  return request;
}

void CheckConsistency(JsonReader& reader, ActionRequest& request) {
  IdentifySelf(reader, request.observation);
  CheckView(reader, request.observation, request.settings);
  CheckAgents(reader, request.observation, request.settings.view_radius > 0);
  CheckBombs(reader, request.observation);
  CheckFlames(reader, request.observation);
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
  ActionRequest request = ReadObservation(reader, object);
  if (reader.ok()) CheckConsistency(reader, request);
  if (reader.ok()) CheckSides(reader, object, request.settings, request.observation.self);
  return Finished(reader, request);
}

Parsed<int> ParseEpisodeEnd(std::string_view body) {
  JsonReader reader;
  const Json object = reader.Parse(body, "the body", kMaxJsonDepth);
  return Finished(reader, reader.Integer(Decoded(reader, object, "reward"), "reward", -1, 1));
}

}  // namespace powderkeg

#include "common/recorded/recorded_game.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/check.h"
#include "common/recorded/json_lines.h"

namespace powderkeg {
namespace {

using Json = nlohmann::json;

constexpr int kSmallBoardSize = 8;

// ---- Reading JSON: every function throws Error on what does not fit. ----

const Json& Field(const Json& object, const char* name) {
  if (!object.is_object() || !object.contains(name)) throw Error(StrCat("no field \"", name, '"'));
  return object.at(name);
}

Json ParseJson(std::string_view text) {
  Json json = Json::parse(text, /*cb=*/nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded()) throw Error("not a JSON object");
  return json;
}

int Number(const Json& json, int lowest, int highest) {
  if (json.is_number()) {
    const auto value = json.get<double>();
    const bool fits = value >= lowest && value <= highest;
    if (fits && value == static_cast<int>(value)) return static_cast<int>(value);
  }
  throw Error(StrCat(json.dump(), " is no whole number from ", lowest, " to ", highest));
}

template <typename Integer>
Integer NumberOf(const Json& json) {
  using Limits = std::numeric_limits<Integer>;
  return static_cast<Integer>(Number(json, Limits::min(), Limits::max()));
}

bool Flag(const Json& json) {
  if (json.is_boolean()) return json.get<bool>();
  return Number(json, 0, 1) != 0;
}

std::string Text(const Json& json) {
  if (!json.is_string()) throw Error(StrCat(json.dump(), " is no string"));
  return json.get<std::string>();
}

const Json& List(const Json& json, std::size_t lowest, std::size_t highest) {
  if (!json.is_array() || json.size() < lowest || json.size() > highest) {
    throw Error(StrCat(json.dump().substr(0, 200), " is no list of ", lowest, " to ", highest));
  }
  return json;
}

const Json& List(const Json& json, std::size_t size) { return List(json, size, size); }

std::uint8_t CellOf(const Json& row, const Json& column) {
  return static_cast<std::uint8_t>(
      CellAt(Number(row, 0, kBoardSize - 1), Number(column, 0, kBoardSize - 1)));
}

Item ItemOf(const Json& json) {
  constexpr int kFirst = static_cast<int>(CellValue::kExtraBomb);
  return static_cast<Item>(Number(json, kFirst, kFirst + 2) - kFirst + 1);
}

std::array<std::uint8_t, kCellCount> Numbers(const Json& json) { return BoardNumbers(Text(json)); }

std::array<std::uint8_t, kCellCount> BoardOf(const Json& json) {
  return BoardNumbers(Text(json), CellValue::kRigid);
}

// One value for each agent that plays.
const Json& SeatList(const Json& json) {
  if (json.is_array() && json.size() == SeatCount(Mode::kOneVsOne)) return json;
  return List(json, kAgentCount);
}

CellValue CellValueOf(int digit) {
  constexpr int kLast = static_cast<int>(AgentValue(kAgentCount - 1));
  if (digit < 0 || digit > kLast) throw Error(StrCat("no cell has the value ", digit));
  return static_cast<CellValue>(digit);
}

// ---- States ----

// Walls, wood and visible items of a board; whatever else it shows comes from the lists.
void ReadBoard(const std::array<std::uint8_t, kCellCount>& board, State& state) {
  for (Cell cell = 0; cell < kCellCount; ++cell) {
    switch (CellValueOf(board[cell])) {
      case CellValue::kRigid: state.rigid.Add(cell); break;
      case CellValue::kWood: state.wood.Add(cell); break;
      case CellValue::kExtraBomb: state.SetItem(cell, Item::kExtraBomb); break;
      case CellValue::kIncreaseRange: state.SetItem(cell, Item::kIncreaseRange); break;
      case CellValue::kKick: state.SetItem(cell, Item::kKick); break;
      default: break;
    }
  }
}

AgentState ReadAgent(const Json& json) {
  List(json, 6);
  return {.cell = CellOf(json[0], json[1]),
          .ammo = NumberOf<std::uint8_t>(json[3]),
          .blast_strength = NumberOf<std::uint8_t>(json[4]),
          .alive = Flag(json[2]),
          .can_kick = Flag(json[5])};
}

void ReadBombs(const Json& json, State& state) {
  for (const Json& entry : List(json, 0, kMaxBombs)) {
    List(entry, 6);
    Bomb bomb{.cell = CellOf(entry[1], entry[2]),
              .life = NumberOf<std::int8_t>(entry[3]),
              .blast_strength = static_cast<std::uint8_t>(Number(entry[4], 1, UINT8_MAX))};
    bomb.set_owner(Number(entry[0], 0, kAgentCount - 1));
    if (!entry[5].is_null()) bomb.set_direction(static_cast<Direction>(Number(entry[5], 1, 4)));
    if (state.bomb_cells.Has(bomb.cell)) throw Error("two bombs on a cell");
    state.AddBomb(bomb);
  }
}

void ReadFlames(const Json& json, State& state) {
  for (const Json& flame : List(json, 0, kCellCount * state.flames.size())) {
    List(flame, 3);
    const int life = Number(flame[2], 0, static_cast<int>(state.flames.size()) - 1);
    state.flames[life].Add(CellOf(flame[0], flame[1]));
  }
}

void ReadHiddenItems(const Json& json, State& state) {
  for (const Json& item : List(json, 0, kCellCount)) {
    List(item, 3);
    const Cell cell = CellOf(item[0], item[1]);
    if (!(state.wood | state.Flames()).Has(cell)) throw Error("a hidden item lies open");
    state.SetItem(cell, ItemOf(item[2]));
  }
}

void CheckBoard(const std::array<std::uint8_t, kCellCount>& board, const State& state) {
  for (Cell cell = 0; cell < kCellCount; ++cell) {
    if (board[cell] != static_cast<int>(state.ValueAt(cell))) {
      throw Error(StrCat("board and lists disagree at (", RowOf(cell), ',', ColumnOf(cell), ')'));
    }
  }
}

State ReadState(const Json& json) {
  State state;
  const auto board = BoardOf(Field(json, "b"));
  ReadBoard(board, state);
  state.step = NumberOf<std::uint16_t>(Field(json, "n"));
  const Json& agents = SeatList(Field(json, "ag"));
  std::ranges::transform(agents, state.agents.begin(), ReadAgent);
  ReadBombs(Field(json, "bo"), state);
  ReadFlames(Field(json, "fl"), state);
  ReadHiddenItems(Field(json, "it"), state);
  CheckBoard(board, state);
  return state;
}

// ---- Observations ----

Message ReadMessage(const Json& json) {
  List(json, 2);
  return {NumberOf<std::uint8_t>(json[0]), NumberOf<std::uint8_t>(json[1])};
}

void ReadCells(const Json& json, Observation& observation) {
  const auto board = BoardOf(Field(json, "board"));
  const auto directions = Numbers(Field(json, "bomb_moving_direction"));
  for (Cell cell = 0; cell < kCellCount; ++cell) {
    observation.board[cell] = CellValueOf(board[cell]);
    if (directions[cell] > static_cast<int>(Direction::kRight)) {
      throw Error(StrCat("no direction has the value ", int{directions[cell]}));
    }
    observation.bomb_moving_direction[cell] = static_cast<Direction>(directions[cell]);
  }
  observation.bomb_blast_strength = Numbers(Field(json, "bomb_blast_strength"));
  observation.bomb_life = Numbers(Field(json, "bomb_life"));
  observation.flame_life = Numbers(Field(json, "flame_life"));
  if (std::ranges::max(observation.flame_life) > 3) throw Error("a flame lives longer than 3");
}

CellValue ReadCellValue(const Json& json) { return CellValueOf(NumberOf<std::uint8_t>(json)); }

RecordedObservation ReadObservation(const Json& json, AgentId self) {
  RecordedObservation recorded{};
  Observation& observation = recorded.observation;
  observation.self = self;
  ReadCells(json, observation);
  for (const Json& living : List(Field(json, "alive"), 0, kAgentCount)) {
    constexpr int kFirst = static_cast<int>(CellValue::kAgent0);
    observation.alive[Number(living, kFirst, kFirst + kAgentCount - 1) - kFirst] = true;
  }
  const Json& position = List(Field(json, "position"), 2);
  observation.position = CellOf(position[0], position[1]);
  observation.blast_strength = NumberOf<std::uint8_t>(Field(json, "blast_strength"));
  observation.can_kick = Flag(Field(json, "can_kick"));
  observation.ammo = NumberOf<std::uint8_t>(Field(json, "ammo"));
  observation.step = NumberOf<std::uint16_t>(Field(json, "step_count"));
  if (json.contains("message")) observation.message = ReadMessage(json.at("message"));
  recorded.team_mate = ReadCellValue(Field(json, "teammate"));
  const Json& enemies = List(Field(json, "enemies"), 0, kAgentCount - 1);
  std::ranges::transform(enemies, std::back_inserter(recorded.enemies), ReadCellValue);
  recorded.game_type = Number(Field(json, "game_type"), 1, 4);
  recorded.environment = Text(Field(json, "game_env"));
  return recorded;
}

RecordedObservations ReadObservations(const Json& json) {
  RecordedObservations observations;
  for (const Json& seen : SeatList(json)) {
    observations.push_back(ReadObservation(seen, static_cast<AgentId>(observations.size())));
  }
  return observations;
}

// ---- Games ----

GameSettings ReadSettings(const Json& header, Mode mode) {
  GameSettings settings;
  settings.mode = mode;
  if (mode == Mode::kOneVsOne) settings.board_size = kSmallBoardSize;
  settings.max_steps = Number(Field(header, "max_steps"), 1, UINT16_MAX);
  settings.blast_strength_cap = Number(Field(header, "blast_cap"), 1, UINT8_MAX);
  const Json& view = Field(header, "view");
  settings.view_radius = view.is_null() ? 0 : Number(view, 1, kBoardSize);
  const Json& collapses = List(Field(header, "collapses"), 0, settings.collapse_steps.size());
  std::ranges::transform(collapses, settings.collapse_steps.begin(),
                         [](const Json& step) { return Number(step, 1, UINT16_MAX); });
  return settings;
}

void ReadWords(const Json& json, std::array<Message, kAgentCount>& messages) {
  List(json, kAgentCount);
  for (AgentId id = 0; id < kAgentCount; ++id) {
    if (!json[id].is_null()) messages[id] = ReadMessage(json[id]);
  }
}

RecordedGame ReadHeader(const Json& json) {
  if (Number(Field(json, "v"), 0, INT32_MAX) != 1) throw Error("version is not 1");
  RecordedGame game;
  game.id = Text(Field(json, "id"));
  game.mode = Text(Field(json, "mode"));
  const std::optional<Mode> mode = RecordedModeFor(game.mode);
  if (!mode) return game;
  game.environment = Text(Field(json, "env"));
  if (json.contains("tag")) game.tag = Text(json.at("tag"));
  game.settings = ReadSettings(json, *mode);
  game.start = ReadState(Field(json, "state"));
  if (json.contains("words")) ReadWords(json.at("words"), game.start.messages);
  if (json.contains("obs")) game.observations = ReadObservations(json.at("obs"));
  return game;
}

// The words that arrive: those of agents that were alive before the step.
void KeepWordsOfLiving(const State& before, std::array<Message, kAgentCount>& messages) {
  for (AgentId id = 0; id < kAgentCount; ++id) {
    if (!before.agents[id].alive) messages[id] = {};
  }
}

RecordedStep ReadStep(const Json& json, const State& before) {
  RecordedStep step;
  std::ranges::transform(SeatList(Field(json, "a")), step.actions.begin(), [](const Json& action) {
    return static_cast<Action>(Number(action, 0, kActionCount - 1));
  });
  std::ranges::transform(SeatList(Field(json, "r")), step.rewards.begin(), [](const Json& reward) {
    return static_cast<std::int8_t>(Number(reward, -1, 1));
  });
  step.done = Flag(Field(json, "d"));
  if (json.contains("m")) ReadWords(json.at("m"), step.messages);
  step.state = ReadState(Field(json, "s"));
  step.state.messages = step.messages;
  KeepWordsOfLiving(before, step.state.messages);
  if (json.contains("o")) step.observations = ReadObservations(json.at("o"));
  return step;
}

Result ResultOf(std::string_view name) {
  if (name == "Win") return Result::kWin;
  if (name == "Tie") return Result::kTie;
  if (name == "Incomplete") return Result::kIncomplete;
  throw Error(StrCat("unknown result '", name, '\''));
}

void ReadEnd(const Json& json, RecordedGame& game) {
  game.result = ResultOf(Text(Field(json, "result")));
  if (const Json& winners = Field(json, "winners"); !winners.is_null()) {
    for (const Json& winner : List(winners, 0, kAgentCount)) {
      game.winners =
          static_cast<std::uint8_t>(game.winners | 1 << Number(winner, 0, kAgentCount - 1));
    }
  }
  if (static_cast<int>(game.steps.size()) != Number(Field(json, "steps"), 0, INT32_MAX)) {
    throw Error(StrCat("the game has ", game.steps.size(), " steps, its end says otherwise"));
  }
}

// Takes one more line of a game whose header was read; whether it was the last.
bool ReadLine(const Json& json, RecordedGame& game) {
  const std::string kind = Text(Field(json, "t"));
  if (kind != "step" && kind != "end") throw Error(StrCat("unexpected line of kind '", kind, '\''));
  if (kind == "end") {
    if (game.Known()) ReadEnd(json, game);
    return true;
  }
  if (game.Known()) {
    const State& before = game.steps.empty() ? game.start : game.steps.back().state;
    game.steps.push_back(ReadStep(json, before));
  }
  return false;
}

}  // namespace

std::array<std::uint8_t, kCellCount> BoardNumbers(std::string_view digits, CellValue beyond) {
  const int size = digits.size() == kCellCount ? kBoardSize : kSmallBoardSize;
  if (static_cast<int>(digits.size()) != size * size) {
    throw Error(StrCat("board of ", digits.size(), " cells, expected 121 or 64"));
  }
  std::array<std::uint8_t, kCellCount> numbers{};
  numbers.fill(static_cast<std::uint8_t>(beyond));
  int cell = 0;  // among those in play
  for (const char digit : digits) {
    const std::size_t number = kBoardDigits.find(digit);
    if (number == std::string_view::npos) {
      throw Error(StrCat("board has a cell '", digit, "', expected 0-9 or a-z"));
    }
    numbers[CellAt(cell / size, cell % size)] = static_cast<std::uint8_t>(number);
    ++cell;
  }
  return numbers;
}

std::optional<Mode> RecordedModeFor(std::string_view name) {
  if (name == "ffa") return Mode::kFreeForAll;
  if (name == "team") return Mode::kTeam;
  if (name == "radio") return Mode::kTeamRadio;
  if (name == "one_vs_one") return Mode::kOneVsOne;
  return std::nullopt;
}

RecordedGameReader::RecordedGameReader(const std::string& path)
    : name_(path), lines_([reader = std::make_shared<LineReader>(path)](std::string& line) {
        return reader->Next(line);
      }) {}

RecordedGameReader::RecordedGameReader(std::string name, LineSource lines)
    : name_(std::move(name)), lines_(std::move(lines)) {}

bool RecordedGameReader::Next(RecordedGame& game) {
  std::string line;
  if (!lines_(line)) return false;
  ++line_number_;
  try {
    const Json header = ParseJson(line);
    if (Text(Field(header, "t")) != "game") throw Error("expected the header of a game");
    game = ReadHeader(header);
    for (bool ended = false; !ended;) {
      if (!lines_(line)) throw Error("the file ends within a game");
      ++line_number_;
      ended = ReadLine(ParseJson(line), game);
    }
  } catch (const Error& error) {
    throw Error(StrCat(name_, ':', line_number_, ": ", error.what()));
  }
  return true;
}

}  // namespace powderkeg

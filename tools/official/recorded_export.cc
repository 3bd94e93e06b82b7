#include "tools/official/recorded_export.h"

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "common/base/check.h"

namespace powderkeg {
namespace {

// --- JSON text ----------------------------------------------------------------------------------

std::string Quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char character : text) {
    const bool control = static_cast<unsigned char>(character) < 0x20;
    if (character == '"' || character == '\\') quoted += '\\';
    quoted += control ? ' ' : character;
  }
  return quoted + '"';
}

// [a,b,c] of the texts that `text` makes of the values.
template <typename Values, typename Text>
std::string List(const Values& values, Text text) {
  std::string list;
  for (const auto& value : values) list += StrCat(list.empty() ? "" : ",", text(value));
  return "[" + list + "]";
}

// A number as text, whatever integer or enumeration it is.
constexpr auto kNumber = [](auto value) { return StrCat(static_cast<int>(value)); };

// What is stored of those who play.
template <typename Value>
std::span<const Value> Playing(const std::array<Value, kAgentCount>& values, Mode mode) {
  return std::span(values).first(static_cast<std::size_t>(SeatCount(mode)));
}

std::string Words(const std::array<Message, kAgentCount>& messages) {
  return List(messages, [](const Message& message) { return List(message, kNumber); });
}

// The agents whose flag is set, numbered from `first`.
std::string Agents(const std::array<bool, kAgentCount>& flags, int first) {
  std::string list;
  for (AgentId id = 0; id < kAgentCount; ++id) {
    if (flags[id]) list += StrCat(list.empty() ? "" : ",", first + id);
  }
  return "[" + list + "]";
}

// A digit in quotes for each cell in play.
template <typename Cells>
std::string Digits(const Cells& cells, int size) {
  std::string digits;
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      digits += kBoardDigits[static_cast<int>(cells[CellAt(row, column)])];
    }
  }
  return Quoted(digits);
}

// --- Positions ----------------------------------------------------------------------------------

// Lists of (row, column, number).
using CellNumbers = std::vector<std::array<int, 3>>;

std::string ListOf(const CellNumbers& entries) {
  return List(entries, [](const auto& entry) { return List(entry, kNumber); });
}

std::string AgentText(const AgentState& agent) {
  return List(std::array<int, 6>{RowOf(agent.cell), ColumnOf(agent.cell), agent.alive, agent.ammo,
                                 agent.blast_strength, agent.can_kick},
              kNumber);
}

std::string BombText(const Bomb& bomb) {
  const bool rolls = bomb.direction() != Direction::kNone;
  return StrCat("[", bomb.owner(), ",", RowOf(bomb.cell), ",", ColumnOf(bomb.cell), ",",
                int{bomb.life}, ",", int{bomb.blast_strength}, ",",
                rolls ? kNumber(bomb.direction()) : "null", "]");
}

std::string PositionText(const State& state, const GameSettings& settings) {
  std::array<CellValue, kCellCount> board{};
  for (Cell cell = 0; cell < kCellCount; ++cell) board[cell] = state.ValueAt(cell);
  CellNumbers flames;
  for (int life = 0; life < static_cast<int>(state.flames.size()); ++life) {
    ForEachCell(state.flames[life], [&](Cell cell) {
      flames.push_back({RowOf(cell), ColumnOf(cell), life});
    });
  }
  CellNumbers items;
  ForEachCell(state.HiddenItems(), [&](Cell cell) {
    constexpr int kBeforeFirst = static_cast<int>(CellValue::kExtraBomb) - 1;
    items.push_back(
        {RowOf(cell), ColumnOf(cell), kBeforeFirst + static_cast<int>(state.ItemAt(cell))});
  });
  return StrCat(R"({"ag":)", List(Playing(state.agents, settings.mode), AgentText), R"(,"b":)",
                Digits(board, settings.board_size), R"(,"bo":)", List(state.Bombs(), BombText),
                R"(,"fl":)", ListOf(flames), R"(,"it":)", ListOf(items), R"(,"n":)", state.step,
                "}");
}

// --- Observations -------------------------------------------------------------------------------

std::string ObservationText(const RecordedObservation& recorded, const GameSettings& settings) {
  const Observation& seen = recorded.observation;
  const int size = settings.board_size;
  std::string text = StrCat(
      R"({"alive":)", Agents(seen.alive, static_cast<int>(CellValue::kAgent0)), R"(,"board":)",
      Digits(seen.board, size), R"(,"bomb_blast_strength":)",
      Digits(seen.bomb_blast_strength, size), R"(,"bomb_life":)", Digits(seen.bomb_life, size),
      R"(,"bomb_moving_direction":)", Digits(seen.bomb_moving_direction, size), R"(,"flame_life":)",
      Digits(seen.flame_life, size));
  text += StrCat(R"(,"game_type":)", recorded.game_type, R"(,"game_env":)",
                 Quoted(recorded.environment), R"(,"position":[)", RowOf(seen.position), ",",
                 ColumnOf(seen.position), R"(],"blast_strength":)", int{seen.blast_strength},
                 R"(,"can_kick":)", seen.can_kick ? "true" : "false", R"(,"teammate":)",
                 kNumber(recorded.team_mate), R"(,"ammo":)", int{seen.ammo}, R"(,"enemies":)",
                 List(recorded.enemies, kNumber), R"(,"step_count":)", seen.step);
  if (settings.mode == Mode::kTeamRadio) text += R"(,"message":)" + List(seen.message, kNumber);
  return text + "}";
}

std::string ObservationsText(const RecordedObservations& observations,
                             const GameSettings& settings) {
  return List(observations, [&](const RecordedObservation& recorded) {
    return ObservationText(recorded, settings);
  });
}

// --- Lines --------------------------------------------------------------------------------------

std::string CollapseSteps(const GameSettings& settings) {
  return settings.collapse_steps == GameSettings{}.collapse_steps
             ? "[]"
             : List(settings.collapse_steps, kNumber);
}

std::string Header(const RecordedGame& game) {
  const GameSettings& settings = game.settings;
  std::string line =
      StrCat(R"({"t":"game","v":1,"id":)", Quoted(game.id), R"(,"env":)", Quoted(game.environment),
             R"(,"mode":)", Quoted(game.mode), R"(,"max_steps":)", settings.max_steps,
             R"(,"blast_cap":)", settings.blast_strength_cap, R"(,"view":)",
             settings.view_radius == 0 ? "null" : StrCat(settings.view_radius), R"(,"collapses":)",
             CollapseSteps(settings), R"(,"tag":)", Quoted(game.tag), R"(,"state":)",
             PositionText(game.start, settings));
  if (settings.mode == Mode::kTeamRadio) line += R"(,"words":)" + Words(game.start.messages);
  if (game.observations) {
    line += R"(,"obs":)" + ObservationsText(*game.observations, settings);
  }
  return line + "}\n";
}

std::string StepLine(const RecordedStep& step, const GameSettings& settings) {
  const Mode mode = settings.mode;
  std::string line = R"({"t":"step","a":)" + List(Playing(step.actions, mode), kNumber);
  if (mode == Mode::kTeamRadio) line += R"(,"m":)" + Words(step.messages);
  line +=
      StrCat(R"(,"s":)", PositionText(step.state, settings), R"(,"r":)",
             List(Playing(step.rewards, mode), kNumber), R"(,"d":)", step.done ? "true" : "false");
  if (step.observations) line += R"(,"o":)" + ObservationsText(*step.observations, settings);
  return line + "}\n";
}

std::string EndLine(const RecordedGame& game) {
  std::array<bool, kAgentCount> won{};
  for (AgentId id = 0; id < kAgentCount; ++id) won[id] = Has(game.winners, id);
  const std::string_view result = game.result == Result::kWin   ? "Win"
                                  : game.result == Result::kTie ? "Tie"
                                                                : "Incomplete";
  return StrCat(R"({"t":"end","result":)", Quoted(result), R"(,"winners":)",
                game.result == Result::kWin ? Agents(won, 0) : "null", R"(,"steps":)",
                game.steps.size(), "}\n");
}

}  // namespace

std::string RecordedLines(const RecordedGame& game) {
  if (!game.Known()) {
    throw Error(StrCat("cannot export ", game.id, ": mode \"", game.mode,
                       "\", expected ffa, team, radio or one_vs_one"));
  }
  std::string lines = Header(game);
  for (const RecordedStep& step : game.steps) lines += StepLine(step, game.settings);
  return lines + EndLine(game);
}

}  // namespace powderkeg

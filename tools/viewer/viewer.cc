#include "tools/viewer/viewer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <string_view>
#include <vector>

#include "common/base/check.h"

namespace powderkeg {
namespace {

constexpr std::string_view kResetColour = "\033[0m";

// --- Cells --------------------------------------------------------------------------------------

// Black on the colour of the agent.
constexpr std::array<std::string_view, kAgentCount> kAgentColours = {
    "\033[1;30;46m", "\033[1;30;45m", "\033[1;30;42m", "\033[1;30;44m"};

char BombSymbol(Direction direction) {
  switch (direction) {
    case Direction::kNone: return 'o';
    case Direction::kUp: return '^';
    case Direction::kDown: return 'v';
    case Direction::kLeft: return '<';
    case Direction::kRight: return '>';
  }
  return 'o';
}

int LongestFlame(const State& state, Cell cell) {
  int life = static_cast<int>(state.flames.size()) - 1;
  while (life > 0 && !state.flames[life].Has(cell)) --life;
  return life;
}

// Two characters.
std::string CellText(const State& state, Cell cell) {
  const CellValue value = state.ValueAt(cell);
  const Bomb* bomb = state.BombAt(cell);
  const std::string life = bomb == nullptr ? "" : StrCat(int{bomb->life});
  switch (value) {
    case CellValue::kPassage: return "..";
    case CellValue::kRigid: return "##";
    case CellValue::kWood: return "++";
    case CellValue::kBomb: return BombSymbol(bomb->direction()) + life;
    case CellValue::kFlames: return StrCat("*", LongestFlame(state, cell));
    case CellValue::kExtraBomb: return "+b";
    case CellValue::kIncreaseRange: return "+r";
    case CellValue::kKick: return "+k";
    default: break;
  }
  const int agent = static_cast<int>(value) - static_cast<int>(CellValue::kAgent0);
  return bomb == nullptr ? StrCat("A", agent) : StrCat(agent, life);
}

std::string_view CellColour(CellValue value) {
  switch (value) {
    case CellValue::kPassage: return "\033[90m";
    case CellValue::kRigid: return "\033[37;100m";
    case CellValue::kWood: return "\033[30;43m";
    case CellValue::kBomb: return "\033[1;97;40m";
    case CellValue::kFlames: return "\033[1;93;41m";
    case CellValue::kExtraBomb:
    case CellValue::kIncreaseRange:
    case CellValue::kKick: return "\033[1;96m";
    default: break;
  }
  return kAgentColours[static_cast<int>(value) - static_cast<int>(CellValue::kAgent0)];
}

std::string Paint(std::string_view text, std::string_view colour, Colours colours) {
  if (colours == Colours::kNone) return std::string(text);
  return StrCat(colour, text, kResetColour);
}

// Right-aligned in `width` characters.
std::string Number(int number, int width) {
  std::string text = StrCat(number);
  return std::string(std::max<std::size_t>(width, text.size()) - text.size(), ' ') + text;
}

// The column numbers and the rows.
std::vector<std::string> BoardLines(const State& state, Colours colours) {
  std::vector<std::string> lines(1, "  ");
  for (int column = 0; column < kBoardSize; ++column) lines[0] += Number(column, 3);
  for (int row = 0; row < kBoardSize; ++row) {
    std::string line = Number(row, 2);
    for (int column = 0; column < kBoardSize; ++column) {
      const Cell cell = CellAt(row, column);
      line += ' ';
      line += Paint(CellText(state, cell), CellColour(state.ValueAt(cell)), colours);
    }
    lines.push_back(line);
  }
  return lines;
}

// --- What is known of the agents ----------------------------------------------------------------

std::string AgentLine(const StoredGame& stored, const State& state, AgentId id, Colours colours) {
  const AgentState& agent = state.agents[id];
  std::string line = Paint(StrCat("A", id), kAgentColours[id], colours);
  if (!stored.players[id].empty()) line += " " + stored.players[id];
  line += StrCat(agent.alive ? " at (" : " died at (", RowOf(agent.cell), ",", ColumnOf(agent.cell),
                 ") ammo ", int{agent.ammo}, " strength ", int{agent.blast_strength},
                 agent.can_kick ? " kick" : "");
  return line;
}

std::string MoveLine(const RecordedGame& game, const State& state, int step, AgentId id) {
  if (step == static_cast<int>(game.steps.size()) || !state.agents[id].alive) return "";
  const RecordedStep& played = game.steps[step];
  std::string line = StrCat("   plays ", kActionNames[static_cast<int>(played.actions[id])]);
  if (const Message& words = played.messages[id]; words != Message{}) {
    line += StrCat(" and says ", int{words[0]}, " ", int{words[1]});
  }
  return line;
}

// "visits stop 3% up 91% ..., value +0.25"
std::string SearchText(const Decision& decision) {
  const int sum = std::accumulate(decision.visits.begin(), decision.visits.end(), 0);
  std::string text = "; visits";
  for (int action = 0; action < kActionCount; ++action) {
    if (decision.visits[action] == 0) continue;
    const int percent = static_cast<int>(std::lround(100.0 * decision.visits[action] / sum));
    text += StrCat(" ", kActionNames[action], " ", percent, "%");
  }
  std::array<char, 32> value{};
  std::snprintf(value.data(), value.size(), ", value %+.2f", double{decision.value});
  return text + value.data();
}

std::string DecisionText(const StoredGame& stored, int step, AgentId id) {
  const std::vector<Decision>& decisions = stored.tracks[id].decisions;
  const auto found = std::ranges::find(decisions, step, &Decision::step);
  return found == decisions.end() ? "" : SearchText(*found);
}

std::string EndLine(const RecordedGame& game) {
  switch (game.result) {
    case Result::kIncomplete: return "the record ends here";
    case Result::kTie: return "tie";
    case Result::kWin: break;
  }
  std::string line = "won by";
  for (AgentId id = 0; id < kAgentCount; ++id) {
    if (Has(game.winners, id)) line += StrCat(" A", id);
  }
  return line;
}

std::vector<std::string> SideLines(const StoredGame& stored, int step, Colours colours) {
  const State& state = PositionAfter(stored.game, step);
  std::vector<std::string> lines(1);
  for (AgentId id = 0; id < kAgentCount; ++id) {
    lines.push_back(AgentLine(stored, state, id, colours));
    lines.push_back(MoveLine(stored.game, state, step, id) + DecisionText(stored, step, id));
  }
  lines.emplace_back();
  const bool last = step == static_cast<int>(stored.game.steps.size());
  lines.push_back(last ? EndLine(stored.game) : "");
  return lines;
}

}  // namespace

std::string RenderStep(const StoredGame& stored, int step, Colours colours) {
  const std::vector<std::string> board = BoardLines(PositionAfter(stored.game, step), colours);
  const std::vector<std::string> side = SideLines(stored, step, colours);
  std::string text = StrCat(stored.game.environment, " ", stored.game.id, " step ",
                            PositionAfter(stored.game, step).step, ", ", step, " of ",
                            stored.game.steps.size(), "\n");
  for (std::size_t i = 0; i < board.size(); ++i) {
    text += board[i];
    if (i < side.size() && !side[i].empty()) text += "   " + side[i];
    text += '\n';
  }
  return text;
}

}  // namespace powderkeg

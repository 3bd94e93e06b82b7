#include "common/pommerman/board_text.h"

#include "common/base/check.h"

namespace powderkeg {
namespace {

std::string CellText(Cell cell) { return StrCat('(', RowOf(cell), ',', ColumnOf(cell), ')'); }

std::string AgentLine(AgentId id, const AgentState& agent, const Message& words) {
  std::string line = StrCat("agent ", id);
  if (!agent.alive) line += StrCat(" dead ", CellText(agent.cell));
  line += StrCat(" ammo ", int{agent.ammo}, " strength ", int{agent.blast_strength});
  if (agent.can_kick) line += " kick";
  if (words != Message{}) line += StrCat(" words ", int{words[0]}, ' ', int{words[1]});
  return line + '\n';
}

std::string BombLine(const Bomb& bomb) {
  std::string line = StrCat("bomb ", CellText(bomb.cell), " owner ", bomb.owner(), " life ",
                            int{bomb.life}, " strength ", int{bomb.blast_strength});
  if (bomb.direction() != Direction::kNone) {
    line += StrCat(" moving ", board_text::kDirectionNames[static_cast<int>(bomb.direction())]);
  }
  return line + '\n';
}

}  // namespace

std::string ToText(const State& state) {
  std::string text;
  for (Cell cell = 0; cell < kCellCount; ++cell) {
    text += board_text::kCellCharacters[static_cast<int>(state.ValueAt(cell))];
    if (ColumnOf(cell) == kBoardSize - 1) text += '\n';
  }
  text += StrCat("step ", state.step, '\n');
  for (AgentId id = 0; id < kAgentCount; ++id) {
    text += AgentLine(id, state.agents[id], state.messages[id]);
  }
  for (const Bomb& bomb : state.Bombs()) text += BombLine(bomb);
  for (int life = 0; life < static_cast<int>(state.flames.size()); ++life) {
    ForEachCell(state.flames[life],
                [&](Cell cell) { text += StrCat("flame ", CellText(cell), " life ", life, '\n'); });
  }
  ForEachCell(state.HiddenItems(), [&](Cell cell) {
    const char item = board_text::kItemCharacters[static_cast<int>(state.ItemAt(cell))];
    text += StrCat("hidden ", CellText(cell), ' ', item, '\n');
  });
  return text;
}

}  // namespace powderkeg

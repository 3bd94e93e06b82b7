#include "tests/pommerman/board_reader.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/check.h"

namespace powderkeg {
namespace {

using board_text::kCellCharacters;
using board_text::kDirectionNames;
using board_text::kItemCharacters;

// The words of one attribute line, read one after the other. Throws Error that quotes the line.
class Words {
 public:
  explicit Words(std::string_view line) : line_(line), rest_(line) {}

  // The next word; empty at the end.
  std::string_view Next() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\r"), rest_.size()));
    const std::string_view word = rest_.substr(0, rest_.find_first_of(" \t\r"));
    rest_.remove_prefix(word.size());
    return word;
  }

  // A number within [lowest, highest].
  int Number(int lowest, int highest) {
    const std::string_view word = Next();
    const std::optional<int> number = NumberIn(word);
    if (!number || *number < lowest || *number > highest) {
      Fail(StrCat('\'', word, "' is no number from ", lowest, " to ", highest));
    }
    return *number;
  }

  // "(row,column)".
  Cell CellWord() {
    const std::string_view word = Next();
    const std::size_t comma = word.find(',');
    if (comma != std::string_view::npos && word.front() == '(' && word.back() == ')') {
      const auto row = NumberIn(word.substr(1, comma - 1));
      const auto column = NumberIn(word.substr(comma + 1, word.size() - comma - 2));
      if (row && column && *row >= 0 && *row < kBoardSize && *column >= 0 && *column < kBoardSize) {
        return CellAt(*row, *column);
      }
    }
    Fail(StrCat('\'', word, "' is no cell such as (0,10)"));
  }

  // The number of the next word in a list of names.
  template <typename Names>
  int OneOf(const Names& names) {
    const std::string_view word = Next();
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (word == names[i]) return static_cast<int>(i);
    }
    Fail(StrCat("unknown word '", word, '\''));
  }

  [[noreturn]] void Fail(const std::string& reason) const {
    throw Error(StrCat("board text, line '", line_, "': ", reason));
  }

 private:
  static std::optional<int> NumberIn(std::string_view word) {
    int number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (word.empty() || error != std::errc() || end != word.data() + word.size()) {
      return std::nullopt;
    }
    return number;
  }

  std::string_view line_;
  std::string_view rest_;
};

std::string_view Trimmed(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t first = line.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return line.substr(first, line.find_last_not_of(kBlanks) - first + 1);
}

// Without the blank ones.
std::vector<std::string_view> Lines(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = Trimmed(text.substr(0, end));
    if (!line.empty()) lines.push_back(line);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return lines;
}

// Puts a State together from the board and the attribute lines.
class Reader {
 public:
  void ReadRow(int row, std::string_view line) {
    if (line.size() != kBoardSize) {
      throw Error(StrCat("board text, row '", line, "': ", line.size(), " cells instead of 11"));
    }
    for (int column = 0; column < kBoardSize; ++column) {
      const std::size_t value = kCellCharacters.find(line[column]);
      if (value == std::string_view::npos || line[column] == '?') {
        throw Error(StrCat("board text, row '", line, "': unknown cell '", line[column], '\''));
      }
      Show(CellAt(row, column), static_cast<CellValue>(value));
    }
  }

  void ReadAttributes(std::string_view line) {
    Words words(line);
    switch (words.OneOf(kLineKinds)) {
      case 0: state_.step = static_cast<std::uint16_t>(words.Number(0, UINT16_MAX)); break;
      case 1: ReadAgent(words); break;
      case 2: ReadBomb(words); break;
      case 3: ReadFlame(words); break;
      default: ReadHiddenItem(words); break;
    }
    if (const auto word = words.Next(); !word.empty()) {
      words.Fail(StrCat("unexpected '", word, '\''));
    }
  }

  // Bombs and flames that the board shows and no line describes become default ones.
  State Finish() {
    ForEachCell(shown_bombs_ & ~state_.bomb_cells, [&](Cell cell) {
      if (state_.bomb_count == kMaxBombs) throw Error("board text: more than 40 bombs");
      state_.AddBomb(Bomb{.cell = static_cast<std::uint8_t>(cell), .life = 9});
    });
    state_.flames[2] |= shown_flames_ & ~state_.Flames();
    if ((state_.HiddenItems() != hidden_items_)) throw Error("board text: a hidden item lies open");
    return state_;
  }

 private:
  static constexpr std::array<std::string_view, 5> kLineKinds = {"step", "agent", "bomb", "flame",
                                                                 "hidden"};

  void Show(Cell cell, CellValue value) {
    switch (value) {
      case CellValue::kRigid: state_.rigid.Add(cell); return;
      case CellValue::kWood: state_.wood.Add(cell); return;
      case CellValue::kBomb: shown_bombs_.Add(cell); return;
      case CellValue::kFlames: shown_flames_.Add(cell); return;
      case CellValue::kExtraBomb: state_.SetItem(cell, Item::kExtraBomb); return;
      case CellValue::kIncreaseRange: state_.SetItem(cell, Item::kIncreaseRange); return;
      case CellValue::kKick: state_.SetItem(cell, Item::kKick); return;
      case CellValue::kPassage:
      case CellValue::kFog:
      case CellValue::kAgentDummy: return;
      default: ShowAgent(static_cast<int>(value) - static_cast<int>(CellValue::kAgent0), cell);
    }
  }

  void ShowAgent(AgentId id, Cell cell) {
    AgentState& agent = state_.agents[id];
    if (agent.alive) throw Error(StrCat("board text: agent ", id, " is on the board twice"));
    agent.alive = true;
    agent.cell = static_cast<std::uint8_t>(cell);
  }

  void ReadAgent(Words& words) {
    const AgentId id = words.Number(0, kAgentCount - 1);
    AgentState& agent = state_.agents[id];
    bool said_dead = false;
    for (std::string_view word = words.Next(); !word.empty(); word = words.Next()) {
      if (word == "dead") {
        said_dead = true;
        if (agent.alive) words.Fail("the agent is on the board");
        agent.cell = static_cast<std::uint8_t>(words.CellWord());
      } else if (word == "ammo") {
        agent.ammo = static_cast<std::uint8_t>(words.Number(0, UINT8_MAX));
      } else if (word == "strength") {
        agent.blast_strength = static_cast<std::uint8_t>(words.Number(1, UINT8_MAX));
      } else if (word == "kick") {
        agent.can_kick = true;
      } else if (word == "words") {
        for (std::uint8_t& said : state_.messages[id]) {
          said = static_cast<std::uint8_t>(words.Number(0, UINT8_MAX));
        }
      } else {
        words.Fail(StrCat("unknown word '", word, '\''));
      }
    }
    if (!agent.alive && !said_dead) words.Fail("the agent is neither on the board nor dead");
  }

  void ReadBomb(Words& words) {
    Bomb bomb{.cell = static_cast<std::uint8_t>(words.CellWord()), .life = 9};
    if (!shown_bombs_.Has(bomb.cell) && !state_.AgentCells().Has(bomb.cell)) {
      words.Fail("the board shows neither bomb nor agent there");
    }
    if (state_.bomb_cells.Has(bomb.cell)) words.Fail("a second bomb on this cell");
    if (state_.bomb_count == kMaxBombs) words.Fail("more than 40 bombs");
    for (std::string_view word = words.Next(); !word.empty(); word = words.Next()) {
      if (word == "owner") {
        bomb.set_owner(words.Number(0, kAgentCount - 1));
      } else if (word == "life") {
        bomb.life = static_cast<std::int8_t>(words.Number(INT8_MIN, INT8_MAX));
      } else if (word == "strength") {
        bomb.blast_strength = static_cast<std::uint8_t>(words.Number(1, UINT8_MAX));
      } else if (word == "moving") {
        bomb.set_direction(static_cast<Direction>(words.OneOf(kDirectionNames)));
      } else {
        words.Fail(StrCat("unknown word '", word, '\''));
      }
    }
    state_.AddBomb(bomb);
  }

  void ReadFlame(Words& words) {
    const Cell cell = words.CellWord();
    if (!shown_flames_.Has(cell)) words.Fail("the board shows no flame there");
    if (words.Next() != "life") words.Fail("expected 'life'");
    state_.flames[words.Number(0, 2)].Add(cell);
  }

  void ReadHiddenItem(Words& words) {
    const Cell cell = words.CellWord();
    const std::string_view kind = words.Next();
    const std::size_t item = kind.size() == 1 ? kItemCharacters.find(kind, 1) : std::string::npos;
    if (item == std::string_view::npos) words.Fail("expected one of b, r, k");
    state_.SetItem(cell, static_cast<Item>(item));
    hidden_items_.Add(cell);
  }

  State state_;
  BitBoard shown_bombs_;
  BitBoard shown_flames_;
  BitBoard hidden_items_;
};

}  // namespace

State FromText(std::string_view text) {
  const std::vector<std::string_view> lines = Lines(text);
  if (lines.size() < kBoardSize) {
    throw Error(StrCat("board text: ", lines.size(), " lines, expected at least 11"));
  }
  Reader reader;
  for (int row = 0; row < kBoardSize; ++row) reader.ReadRow(row, lines[row]);
  for (std::size_t i = kBoardSize; i < lines.size(); ++i) reader.ReadAttributes(lines[i]);
  return reader.Finish();
}

}  // namespace powderkeg

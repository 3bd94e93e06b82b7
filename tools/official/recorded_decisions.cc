#include "tools/official/recorded_decisions.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string_view>

#include "common/base/check.h"
#include "common/pommerman/board_text.h"
#include "common/recorded/json_lines.h"
#include "common/recorded/recorded_game.h"

namespace powderkeg {

namespace {

using Json = nlohmann::json;
using Counts = std::array<int, kActionCount>;

constexpr double kFamilyWiseErrorRate = 0.01;
constexpr int kCalls = 1024;  // of our policy, per record
constexpr double kLeastExpected =
    5;  // of a category in the chi-squared test; smaller ones are pooled
constexpr int kDifferencesShown = 5;

// In this record, counted from 0, the original's 256 equal answers are chance: it plays otherwise
// in 1.5 % of draws.
constexpr int kChanceRecordOfSimpleUnbiased = 3030;

Mode ModeNamed(const std::string& name) {
  const std::optional<Mode> mode = RecordedModeFor(name);
  if (!mode || *mode == Mode::kOneVsOne) {
    throw Error(StrCat("mode ", name, ", expected ffa, team or radio"));
  }
  return *mode;
}

void PlaceValue(Cell cell, int value, RecordedDecision& record) {
  State& state = record.state;
  if (value != static_cast<int>(CellValue::kFog)) record.visible.Add(cell);
  switch (value) {
    case 0:
    case 3:
    case 5: return;
    case 1: return state.rigid.Add(cell);
    case 2: return state.wood.Add(cell);
    case 4: return state.flames[0].Add(cell);
    case 6: return state.SetItem(cell, Item::kExtraBomb);
    case 7: return state.SetItem(cell, Item::kIncreaseRange);
    case 8: return state.SetItem(cell, Item::kKick);
    case 10:
    case 11:
    case 12:
    case 13: {
      AgentState& agent = state.agents[static_cast<std::size_t>(value - 10)];
      agent.alive = true;
      agent.cell = static_cast<std::uint8_t>(cell);
      return;
    }
    default: throw Error(StrCat("board value ", value, ", expected 0 to 8 or 10 to 13"));
  }
}

void ReadBoard(const Json& json, RecordedDecision& record) {
  const auto board = BoardNumbers(json.at("board").get<std::string>());
  const auto strength = BoardNumbers(json.at("bomb_blast_strength").get<std::string>());
  const auto life = BoardNumbers(json.at("bomb_life").get<std::string>());
  if (std::ranges::count_if(strength, [](int digit) { return digit > 0; }) > kMaxBombs) {
    throw Error(StrCat("more than ", kMaxBombs, " bombs"));
  }
  for (Cell cell = 0; cell < kCellCount; ++cell) {
    const auto index = static_cast<std::size_t>(cell);
    PlaceValue(cell, board[index], record);
    if (strength[index] == 0) continue;
    record.state.AddBomb({.cell = static_cast<std::uint8_t>(cell),
                          .life = static_cast<std::int8_t>(life[index]),
                          .blast_strength = static_cast<std::uint8_t>(strength[index])});
  }
}

// The agent on the position becomes the deciding one.
void ReadSelf(const Json& json, RecordedDecision& record) {
  const auto position = json.at("position").get<std::array<int, 2>>();
  const auto& agents = record.state.agents;
  const auto self = std::ranges::find_if(agents, [&](const AgentState& agent) {
    return agent.alive && RowOf(agent.cell) == position[0] && ColumnOf(agent.cell) == position[1];
  });
  if (self == agents.end()) throw Error("no agent on the position");
  record.self = static_cast<AgentId>(self - agents.begin());
  record.state.agents[static_cast<std::size_t>(record.self)].ammo =
      json.at("ammo").get<std::uint8_t>();
}

PolicyMemory ReadRecent(const Json& json) {
  const auto positions = json.get<std::vector<std::array<int, 2>>>();
  PolicyMemory memory;
  if (positions.size() > memory.recent.size()) {
    throw Error(StrCat(positions.size(), " recent positions, expected at most 6"));
  }
  for (const auto [row, column] : positions) {
    if (row < -1 || row > kBoardSize || column < -1 || column > kBoardSize) {
      throw Error(StrCat("recent position ", row, ",", column, ", expected -1 to 11"));
    }
    memory.recent[memory.recent_count++] = RememberedPosition(row, column);
  }
  return memory;
}

PolicyMemory ReadMemory(const Json& json) {
  PolicyMemory memory = ReadRecent(json.at("recent"));
  const Json& direction = json.at("prev_dir");
  if (!direction.is_null()) memory.previous_direction = direction.get<std::uint8_t>();
  return memory;
}

RecordedDecision ReadSimpleUnbiased(const Json& json) {
  RecordedDecision record;
  record.settings.mode = ModeNamed(json.at("mode").get<std::string>());
  ReadBoard(json, record);
  ReadSelf(json, record);
  if (record.self != json.at("id").get<int>()) throw Error("the agent on the position is another");
  record.memory = ReadRecent(json.at("recent"));
  record.counts = json.at("counts").get<Counts>();
  return record;
}

RecordedDecision ReadOfficialSimple(const Json& json) {
  RecordedDecision record;
  record.settings.mode = ModeNamed(json.at("mode").get<std::string>());
  const Json& observation = json.at("obs");
  ReadBoard(observation, record);
  ReadSelf(observation, record);
  record.state.agents[static_cast<std::size_t>(record.self)].blast_strength =
      observation.at("blast_strength").get<std::uint8_t>();
  record.memory = ReadMemory(json.at("mem"));
  record.counts = json.at("counts").get<Counts>();
  record.errors = json.at("errors").get<int>();
  record.chosen = static_cast<Action>(json.at("chosen").get<std::uint8_t>());
  record.memory_after = ReadMemory(json.at("mem_after"));
  return record;
}

// The probability that a chi-squared variable with this many degrees of freedom exceeds `value`:
// Q(n) = Q(n - 2) + (value/2)^(n/2 - 1) e^(-value/2) / Gamma(n/2).
double ChiSquaredTail(double value, int degrees) {
  if (degrees == 0) return 1;
  if (degrees == 1) return std::erfc(std::sqrt(value / 2));
  if (degrees == 2) return std::exp(-value / 2);
  const double half = degrees / 2.0;
  return ChiSquaredTail(value, degrees - 2) +
         std::exp((half - 1) * std::log(value / 2) - value / 2 - std::lgamma(half));
}

// The probability of two samples of one distribution being at least this different. Actions that
// are too rare for the test are taken together.
double HomogeneityProbability(const Counts& a, const Counts& b) {
  const double total_a = std::accumulate(a.begin(), a.end(), 0);
  const double total_b = std::accumulate(b.begin(), b.end(), 0);
  const double smaller = std::min(total_a, total_b) / (total_a + total_b);
  std::vector<std::array<double, 2>> categories;
  std::array<double, 2> rare{};
  for (std::size_t i = 0; i < kActionCount; ++i) {
    if ((a[i] + b[i]) * smaller >= kLeastExpected) {
      categories.push_back({double(a[i]), double(b[i])});
    } else {
      rare[0] += a[i];
      rare[1] += b[i];
    }
  }
  if (rare[0] + rare[1] > 0) categories.push_back(rare);
  double statistic = 0;
  for (const auto& [count_a, count_b] : categories) {
    const double expected_a = (count_a + count_b) * total_a / (total_a + total_b);
    const double expected_b = (count_a + count_b) * total_b / (total_a + total_b);
    statistic += (count_a - expected_a) * (count_a - expected_a) / expected_a +
                 (count_b - expected_b) * (count_b - expected_b) / expected_b;
  }
  return ChiSquaredTail(statistic, static_cast<int>(categories.size()) - 1);
}

bool HasSingleAction(const Counts& counts) { return std::ranges::count(counts, 0) == 5; }

std::string ToString(const Counts& counts) {
  std::string text;
  for (const int count : counts) text += StrCat(text.empty() ? "" : " ", count);
  return text;
}

std::string ToString(const PolicyMemory& memory) {
  std::string text = "recent";
  for (int i = 0; i < memory.recent_count; ++i) {
    const int position = memory.recent[static_cast<std::size_t>(i)];
    text += StrCat(" (", position / 13 - 1, ",", position % 13 - 1, ")");
  }
  return StrCat(text, " previous direction ", int{memory.previous_direction});
}

std::string Describe(const RecordedDecision& record, const std::string& what) {
  return StrCat(what, "\nagent ", record.self, ", ammo ",
                int{record.state.agents[static_cast<std::size_t>(record.self)].ammo}, ", ",
                ToString(record.memory), "\n", ToText(record.state));
}

// What our policy answers in kCalls calls.
struct Answers {
  Counts counts{};
  bool memory_met = false;  // some call chose and remembered what the recorded one did
};

Answers Ask(PolicyKind kind, const RecordedDecision& record, Rng rng) {
  Answers answers;
  const PolicyView view{record.state, record.settings, record.self, record.visible};
  for (int call = 0; call < kCalls; ++call) {
    const PolicyTraits traits = PolicyTraits::Draw(rng);
    PolicyMemory memory = record.memory;
    const Action action = Decide(kind, view, traits, memory, rng);
    ++answers.counts[static_cast<std::size_t>(action)];
    if (action == record.chosen && memory == record.memory_after) answers.memory_met = true;
  }
  return answers;
}

struct FileResult {
  int checked = 0;
  int differences = 0;
  int skipped = 0;
};

std::vector<RecordedDecision> ReadFile(PolicyKind kind, const std::string& path) {
  std::vector<RecordedDecision> records;
  LineReader reader(path);
  std::string line;
  while (reader.Next(line)) {
    try {
      records.push_back(ParseRecordedDecision(kind, line));
    } catch (const Error& error) {
      throw Error(StrCat(path, ":", reader.line_number(), ": ", error.what()));
    }
  }
  if (records.empty()) throw Error(StrCat(path, ": no records"));
  return records;
}

FileResult CheckFile(PolicyKind kind, const std::string& path) {
  const std::vector<RecordedDecision> records = ReadFile(kind, path);
  const double significance = kFamilyWiseErrorRate / static_cast<double>(records.size());
  FileResult result;
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (records[i].errors > 0) {
      ++result.skipped;
      continue;
    }
    ++result.checked;
    const bool chance = kind == PolicyKind::kSimpleUnbiased && i == kChanceRecordOfSimpleUnbiased;
    const auto difference =
        CompareDecision(kind, records[i], significance,
                        chance ? SingleAction::kMayBeChance : SingleAction::kIsCertain, Rng(i));
    if (!difference) continue;
    if (++result.differences <= kDifferencesShown) {
      std::cout << path << ": record " << i << ": " << *difference << "\n";
    }
  }
  return result;
}

}  // namespace

RecordedDecision ParseRecordedDecision(PolicyKind kind, const std::string& line) {
  CHECK(kind == PolicyKind::kSimpleUnbiased || kind == PolicyKind::kOfficialSimple);
  try {
    const Json json = Json::parse(line);
    return kind == PolicyKind::kSimpleUnbiased ? ReadSimpleUnbiased(json)
                                               : ReadOfficialSimple(json);
  } catch (const Json::exception& error) {
    throw Error(StrCat("not a record of ", NameOf(kind), ": ", error.what()));
  }
}

std::optional<std::string> CompareDecision(PolicyKind kind, const RecordedDecision& record,
                                           double significance, SingleAction single, Rng rng) {
  const Answers answers = Ask(kind, record, rng);
  const bool certain = HasSingleAction(record.counts) && single == SingleAction::kIsCertain;
  const double probability = HomogeneityProbability(record.counts, answers.counts);
  if ((certain && !HasSingleAction(answers.counts)) || probability < significance) {
    return Describe(record, StrCat("recorded ", ToString(record.counts), ", ours ",
                                   ToString(answers.counts), ", probability ", probability));
  }
  if (record.chosen && !answers.memory_met) {
    return Describe(record, StrCat("memory after action ", static_cast<int>(*record.chosen),
                                   " never ", ToString(record.memory_after)));
  }
  return std::nullopt;
}

int RunDecisionsCheck(const std::string& agent, const std::vector<std::string>& files) {
  const auto kind = PolicyKindFor(agent);
  if (kind != PolicyKind::kSimpleUnbiased && kind != PolicyKind::kOfficialSimple) {
    throw Error(StrCat("agent ", agent, ", expected simple_unbiased or official_simple"));
  }
  bool differs = false;
  for (const std::string& file : files) {
    const FileResult result = CheckFile(*kind, file);
    std::cout << file << ": " << result.checked << " checked, " << result.differences
              << " differences, " << result.skipped << " skipped\n";
    differs = differs || result.differences > 0;
  }
  return differs ? 1 : 0;
}

}  // namespace powderkeg

#include "common/config/config.h"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "common/base/check.h"

namespace powderkeg {
namespace {

constexpr std::array<std::string_view, 2> kRunSections = {"self_play", "training"};
constexpr std::array<std::string_view, 3> kSelfPlaySections = {"search", "player", "lineup"};
constexpr std::array<std::string_view, 2> kGeneratorNames = {"official", "uniform"};
constexpr std::array<std::string_view, 2> kCornersNames = {"official", "permuted"};
constexpr std::array<std::string_view, 2> kSwapNames = {"at_game_start", "at_once"};

void ReadSelfPlay(std::span<const TextField> fields, SelfPlayConfig& config) {
  ReadOptions(fields, "self_play.", SelfPlayOptions(), config, kSelfPlaySections);
  const bool has_opponents =
      std::ranges::find(fields, "opponents", &TextField::name) != fields.end();
  if (has_opponents) config.lineups.clear();  // they are short for line-ups
  for (const TextField& field : fields) {
    if (field.name == "search") {
      ReadOptions(field.fields, "self_play.search.", SearchOptions(), config.search);
    } else if (field.name == "player") {
      ReadOptions(field.fields, "self_play.player.", PlayerOptions(),
                  config.players.emplace_back());
    } else if (field.name == "lineup") {
      ReadOptions(field.fields, "self_play.lineup.", LineupOptions(),
                  config.lineups.emplace_back());
    }
  }
}

void ReadRun(std::span<const TextField> fields, RunConfig& config) {
  CheckNames(fields, "", {}, kRunSections);
  for (const TextField& field : fields) {
    if (field.name == "self_play") {
      ReadSelfPlay(field.fields, config.self_play);
    } else {
      ReadOptions(field.fields, "training.", TrainingOptions(), config.training);
    }
  }
}

// "section.section.setting=value" as the fields of a file would be.
TextField FieldOf(const std::string& change) {
  const std::size_t equals = change.find('=');
  const std::string place = StrCat("--set ", change, ": ");
  if (equals == std::string::npos || equals == 0) throw Error(place + "expected path=value");
  TextField field{.name = {},
                  .value = change.substr(equals + 1),
                  .fields = {},
                  .is_section = false,
                  .place = place};
  std::string path = change.substr(0, equals);
  for (std::size_t dot = path.rfind('.'); dot != std::string::npos; dot = path.rfind('.')) {
    field.name = path.substr(dot + 1);
    field = {.name = {}, .value = {}, .fields = {field}, .is_section = true, .place = place};
    path.resize(dot);
  }
  field.name = path;
  return field;
}

std::string SectionText(std::string_view name, const std::string& fields, std::string_view indent) {
  return StrCat(indent, name, " {\n", fields, indent, "}\n");
}

std::string SelfPlayText(const SelfPlayConfig& config, const std::string& indent) {
  const std::string deeper = indent + "  ";
  std::string text =
      WriteOptions(SelfPlayOptions(), config, indent) +
      SectionText("search", WriteOptions(SearchOptions(), config.search, deeper), indent);
  for (const PlayerSpec& player : config.players) {
    text += SectionText("player", WriteOptions(PlayerOptions(), player, deeper), indent);
  }
  for (const LineupSpec& lineup : config.lineups) {
    text += SectionText("lineup", WriteOptions(LineupOptions(), lineup, deeper), indent);
  }
  return text;
}

}  // namespace

Names NamesOf(WeightsSwap) { return kSwapNames; }
Names NamesOf(BoardGenerator) { return kGeneratorNames; }
Names NamesOf(StartCorners) { return kCornersNames; }

OptionTable<SelfPlayConfig> SelfPlayOptions() {
  static const std::vector<Option<SelfPlayConfig>> table = {
#define OPTION(type, name, initial, allowed, help) \
  OptionOf<&SelfPlayConfig::name>(#name, allowed, help),
#include "common/config/self_play_options.inc"
  };
  return table;
}

OptionTable<TrainingConfig> TrainingOptions() {
  static const std::vector<Option<TrainingConfig>> table = {
#define OPTION(type, name, initial, allowed, help) \
  OptionOf<&TrainingConfig::name>(#name, allowed, help),
#include "common/config/training_options.inc"
  };
  return table;
}

RunConfig ParseConfig(std::string_view text, const std::string& place,
                      std::span<const std::string> changes) {
  RunConfig config;
  ReadRun(ParseFields(text, place), config);
  for (const std::string& change : changes) {
    const TextField field = FieldOf(change);
    ReadRun({&field, 1}, config);
  }
  FillPlayers(config.self_play);
  (void)ResolvePlayers(config.self_play);
  if (config.training.sequential && config.training.continuous) {
    throw Error("training.sequential and training.continuous are both true; expected at most one");
  }
  return config;
}

RunConfig LoadConfig(const std::string& path, std::span<const std::string> changes) {
  if (path.empty()) return ParseConfig("", "settings", changes);
  std::ifstream file(path);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  if (!file) throw Error(StrCat("cannot read settings \"", path, "\"; expected a text file"));
  return ParseConfig(text, path, changes);
}

SelfPlayConfig ParseSelfPlay(std::string_view text) {
  SelfPlayConfig config;
  ReadSelfPlay(ParseFields(text, "self_play"), config);
  (void)ResolvePlayers(config);
  return config;
}

std::string ToText(const RunConfig& config) {
  return SectionText("self_play", SelfPlayText(config.self_play, "  "), "") +
         SectionText("training", WriteOptions(TrainingOptions(), config.training, "  "), "");
}

std::string ToText(const SelfPlayConfig& config) { return SelfPlayText(config, ""); }

void TieOutcomesToSearch(RunConfig& config) {
  TrainingConfig& training = config.training;
  const SearchSettings& search = config.self_play.search;
  training.draw_value = training.draw_value.value_or(search.draw_value);
  training.late_win_value = training.late_win_value.value_or(search.late_win_value);
}

Sha256Digest SettingsDigest(const SelfPlayConfig& config) {
  const std::string text = ToText(config);
  return Sha256(BytesOf(text));
}

std::string SettingsHelp() {
  return StrCat("Settings of a run, in the file of --config or as --set NAME=VALUE\n\n",
                DescribeOptions(SelfPlayOptions(), "self_play."),
                DescribeOptions(SearchOptions(), "self_play.search."),
                "\nself_play { player { ... } lineup { ... } }: who plays, any number of each\n\n",
                DescribeOptions(PlayerOptions(), "player."),
                DescribeOptions(LineupOptions(), "lineup."), "\n",
                DescribeOptions(TrainingOptions(), "training."));
}

}  // namespace powderkeg

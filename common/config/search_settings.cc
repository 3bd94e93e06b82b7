#include "common/config/search_settings.h"

#include <algorithm>
#include <string>
#include <vector>

namespace powderkeg {
namespace {

constexpr std::array<std::string_view, 2> kTreeNames = {"one_player", "two_player"};
constexpr std::array<std::string_view, 2> kSimulatedOpponentNames = {"closest", "most_dangerous"};
constexpr std::array<std::string_view, 2> kSimulatedMovesNames = {"against_self", "as_foretold"};
constexpr std::array<std::string_view, 2> kRootNames = {"puct", "gumbel"};
constexpr std::array<std::string_view, kOpponentModelCount> kModelNames = {
    "idle",      "random",      "harmless", "simple_unbiased", "official_simple",
    "predicted", "raw_network", "observed", "chosen"};
constexpr std::array<std::string_view, 3> kMemoryNames = {"reset", "synchronized", "inferred"};
constexpr std::array<std::string_view, 4> kPresetNames = {"default", "paper", "gumbel", "katago"};

bool ReadPreset(std::string_view name, const Allowed& /*allowed*/, SearchSettings& settings) {
  if (name == "default") {
    settings = {};
  } else if (name == "paper") {
    settings = PaperSettings();
  } else if (name == "gumbel") {
    settings = GumbelSettings();
  } else if (name == "katago") {
    settings = KataGoSettings();
  } else {
    return false;
  }
  return true;
}

Option<SearchSettings> PresetOption() {
  return {.name = "preset",
          .allowed = kAnything,
          .help = "replaces every option of the search that was said before",
          .read = ReadPreset,
          .write = [](const SearchSettings&, const Allowed&) { return std::string(); },
          .expected = [](const Allowed&) { return "one of " + Joined(kPresetNames, ", "); }};
}

}  // namespace

Names NamesOf(TreeKind) { return kTreeNames; }
Names NamesOf(SimulatedOpponent) { return kSimulatedOpponentNames; }
Names NamesOf(SimulatedMoves) { return kSimulatedMovesNames; }
Names NamesOf(RootSearch) { return kRootNames; }
Names NamesOf(OpponentModel) { return kModelNames; }
Names NamesOf(ModelMemory) { return kMemoryNames; }

bool Predicts(const SearchSettings& settings) {
  const auto asks = [](OpponentModel model) {
    return model == OpponentModel::kPredicted || model == OpponentModel::kChosen;
  };
  return (settings.mate_model && asks(*settings.mate_model)) ||
         std::ranges::any_of(settings.opponents, asks);
}

SearchSettings WithoutAids(SearchSettings settings) {
  settings.caution = 0;
  settings.room = 0;
  settings.hunt = 0;
  settings.policy_temperature = 1;
  return settings;
}

SearchSettings PaperSettings() {
  SearchSettings settings = WithoutAids({});
  settings.opponents.fill(OpponentModel::kSimpleUnbiased);
  settings.memory = ModelMemory::kReset;
  settings.exploratory_start = 0.05;
  settings.step_limit = false;
  settings.tree_reuse = false;
  return settings;
}

SearchSettings GumbelSettings() {
  SearchSettings settings = WithoutAids({});
  settings.root = RootSearch::kGumbel;
  return settings;
}

SearchSettings KataGoSettings() {
  SearchSettings settings = WithoutAids({});
  settings.full_search_share = 0.25;
  settings.forced_playouts = 2;
  return settings;
}

SearchSettings WithoutExploration(SearchSettings settings) {
  settings.noise_weight = 0;
  settings.exploratory_start = 0;
  settings.forced_playouts = 0;
  settings.gumbel_scale = 0;
  settings.temperature = 0;
  settings.full_search_share = 1;
  return settings;
}

OptionTable<SearchSettings> SearchOptions() {
  static const std::vector<Option<SearchSettings>> table = {
      PresetOption(),
#define OPTION(type, name, initial, allowed, help) \
  OptionOf<&SearchSettings::name>(#name, allowed, help),
#include "common/config/search_options.inc"
  };
  return table;
}

}  // namespace powderkeg

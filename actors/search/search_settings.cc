#include "actors/search/search_settings.h"

#include <algorithm>
#include <charconv>
#include <functional>
#include <limits>
#include <optional>
#include <sstream>
#include <variant>

#include "common/base/check.h"

namespace powderkeg {
namespace {

// The texts of an enumeration's values, in their order.
using Names = std::span<const std::string_view>;
constexpr std::array<std::string_view, 2> kTreeNames = {"one_player", "two_player"};
constexpr std::array<std::string_view, 2> kSimulatedOpponentNames = {"closest", "most_dangerous"};
constexpr std::array<std::string_view, 3> kMemoryNames = {"reset", "synchronized", "inferred"};
constexpr std::array<std::string_view, 7> kModelNames = {
    "idle", "random", "harmless", "simple_unbiased", "official_simple", "raw_network", "observed"};
constexpr std::array<std::string_view, 2> kRootNames = {"puct", "gumbel"};
constexpr std::string_view kMateAsOpponents = "as_opponents";
constexpr std::array<std::string_view, 2> kFlagNames = {"false", "true"};

struct Whole {
  int SearchSettings::*member;
  int lowest;
  int highest;
};
struct Real {
  double SearchSettings::*member;
  double lowest;
  double highest;
};
struct Flag {
  bool SearchSettings::*member;
};
// An enumeration: read and written as the index of its name.
struct Choice {
  Names names;
  std::size_t (*read)(const SearchSettings&);
  void (*write)(SearchSettings&, std::size_t);
};
// One model for all others, or three separated by '/'.
struct Models {};
// The model of the mate, or kMateAsOpponents.
struct MateModel {};

struct OptionRow {
  std::string_view name;
  std::variant<Whole, Real, Flag, Choice, Models, MateModel> kind;
  std::string_view help;
};

template <auto member>
Choice ChoiceOf(Names names) {
  return {names, [](const SearchSettings& s) { return static_cast<std::size_t>(s.*member); },
          [](SearchSettings& s, std::size_t index) {
            s.*member = static_cast<std::remove_cvref_t<decltype(s.*member)>>(index);
          }};
}

const std::vector<OptionRow>& Table() {
  using S = SearchSettings;
  static const std::vector<OptionRow> table = {
      {"simulations", Whole{&S::simulations, 1, 1'000'000}, "simulations per move"},
      {"tree", ChoiceOf<&S::tree>(kTreeNames), "whose moves branch"},
      {"simulated_opponent", ChoiceOf<&S::simulated_opponent>(kSimulatedOpponentNames),
       "which enemy moves in a two-player tree"},
      {"simulated_opponent_reach", Whole{&S::simulated_opponent_reach, 1, 20},
       "enemies farther away (Manhattan) act by model"},
      {"opponents", Models{}, "models of the others: one, or three separated by '/'"},
      {"mate_model", MateModel{}, "model of the mate in team modes"},
      {"raw_network_depth", Whole{&S::raw_network_depth, 0, 1000},
       "steps of a simulation in which all models are the network"},
      {"memory", ChoiceOf<&S::memory>(kMemoryNames), "what models keep of the real game"},
      {"c_puct_init", Real{&S::c_puct_init, 0, 100}, "exploration factor"},
      {"c_puct_base", Real{&S::c_puct_base, 1, 1e9}, "visits over which exploration grows"},
      {"unvisited_value", Real{&S::unvisited_value, -1, 1}, "value of an action not yet tried"},
      {"root_unvisited_value", Real{&S::root_unvisited_value, -1, 1}, "the same at the root"},
      {"renormalise_priors", Flag{&S::renormalise_priors}, "priors of the legal actions sum to 1"},
      {"action_filter", Flag{&S::action_filter}, "search legal actions only"},
      {"root", ChoiceOf<&S::root>(kRootNames), "how the root shares its simulations out"},
      {"gumbel_considered", Whole{&S::gumbel_considered, 1, 6},
       "root=gumbel: actions that sequential halving begins with"},
      {"gumbel_first_halving", Whole{&S::gumbel_first_halving, 0, 1'000'000},
       "root=gumbel: simulations of the first of many halvings, each twice as long; 0: one of all"},
      {"gumbel_scale", Real{&S::gumbel_scale, 0, 10}, "root=gumbel: of the noise; 0: none"},
      {"gumbel_c_visit", Real{&S::gumbel_c_visit, 0, 1e6},
       "root=gumbel: visits beside which an action's own weigh little"},
      {"gumbel_c_scale", Real{&S::gumbel_c_scale, 0, 1000},
       "root=gumbel: weight of the values beside the priors"},
      {"noise_alpha", Real{&S::noise_alpha, 0.001, 100}, "Dirichlet parameter at the root"},
      {"noise_weight", Real{&S::noise_weight, 0, 1}, "share of noise in the root's priors"},
      {"exploratory_start", Real{&S::exploratory_start, 0, 1},
       "probability that a simulation starts with a random action"},
      {"temperature", Real{&S::temperature, 0, 100}, "of the move's choice; 0: most visited"},
      {"q_weight", Real{&S::q_weight, 0, 1}, "share of the values in the move's choice"},
      {"q_veto", Real{&S::q_veto, 0, 2}, "lead in value that overrules visits; 0: never"},
      {"forced_playouts", Real{&S::forced_playouts, 0, 100},
       "k of the visits sqrt(k P N) that tried actions get at the root; 0: off"},
      {"full_search_share", Real{&S::full_search_share, 0, 1},
       "moves searched with all simulations and learned as policies"},
      {"fast_simulations", Whole{&S::fast_simulations, 1, 1'000'000},
       "simulations of the other moves"},
      {"draw_value", Real{&S::draw_value, -1, 1}, "value of a tie"},
      {"late_win_value", Real{&S::late_win_value, -1, 1},
       "value of a win in the last step, to which it falls from 1"},
      {"step_limit", Flag{&S::step_limit}, "the search knows that games end after max_steps"},
      {"mate_value_on_death", Flag{&S::mate_value_on_death},
       "team: the network judges for the mate after own death; otherwise -0.5"},
      {"terminal_solver", Flag{&S::terminal_solver}, "prove wins and losses up the tree"},
      {"tree_reuse", Flag{&S::tree_reuse}, "keep the subtree of what happened"},
      {"leaves_per_batch", Whole{&S::leaves_per_batch, 1, 1024}, "leaves asked for at a time"},
  };
  return table;
}

const OptionRow& RowOf(std::string_view name) {
  const auto row = std::ranges::find(Table(), name, &OptionRow::name);
  if (row != Table().end()) return *row;
  std::string known = "preset";
  for (const OptionRow& other : Table()) known += StrCat(", ", other.name);
  throw Error(StrCat("unknown search option '", name, "'; known are: ", known));
}

[[noreturn]] void RefuseValue(std::string_view name, std::string_view value,
                              std::string_view expected) {
  throw Error(StrCat("search option ", name, " = '", value, "': expected ", expected));
}

std::string Joined(Names names, std::string_view separator) {
  std::string text;
  for (const std::string_view name : names) {
    if (!text.empty()) text += separator;
    text += name;
  }
  return text;
}

// What the option accepts, in words.
std::string AllowedFor(const OptionRow& row) {
  if (const auto* whole = std::get_if<Whole>(&row.kind)) {
    return StrCat("a whole number from ", whole->lowest, " to ", whole->highest);
  }
  if (const auto* real = std::get_if<Real>(&row.kind)) {
    return StrCat("a number from ", real->lowest, " to ", real->highest);
  }
  if (const auto* choice = std::get_if<Choice>(&row.kind)) return Joined(choice->names, " or ");
  if (std::holds_alternative<Models>(row.kind)) {
    return "one model, or three separated by '/', of " + Joined(kModelNames, ", ");
  }
  if (std::holds_alternative<MateModel>(row.kind)) {
    return StrCat(kMateAsOpponents, ", ", Joined(kModelNames, ", "));
  }
  return Joined(kFlagNames, " or ");
}

template <typename Number>
std::optional<Number> Parse(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::optional<std::size_t> IndexOf(Names names, std::string_view name) {
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) return std::nullopt;
  return static_cast<std::size_t>(found - names.begin());
}

std::vector<std::string_view> Split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

// The setters return false where the value is not allowed.
template <typename Range, typename Number>
bool SetNumber(const Range& range, std::optional<Number> number, SearchSettings& settings) {
  if (!number || !(*number >= range.lowest && *number <= range.highest)) return false;
  settings.*range.member = *number;
  return true;
}

bool SetModels(std::string_view value, SearchSettings& settings) {
  const std::vector<std::string_view> names = Split(value, '/');
  if (names.size() != 1 && names.size() != settings.opponents.size()) return false;
  auto models = settings.opponents;
  for (std::size_t i = 0; i < models.size(); ++i) {
    const auto index = IndexOf(kModelNames, names[names.size() == 1 ? 0 : i]);
    if (!index) return false;
    models[i] = static_cast<OpponentModel>(*index);
  }
  settings.opponents = models;
  return true;
}

bool SetMateModel(std::string_view value, SearchSettings& settings) {
  const auto index = IndexOf(kModelNames, value);
  if (!index && value != kMateAsOpponents) return false;
  settings.mate_model.reset();
  if (index) settings.mate_model = static_cast<OpponentModel>(*index);
  return true;
}

bool Set(const OptionRow& row, std::string_view value, SearchSettings& settings) {
  if (const auto* whole = std::get_if<Whole>(&row.kind)) {
    return SetNumber(*whole, Parse<int>(value), settings);
  }
  if (const auto* real = std::get_if<Real>(&row.kind)) {
    return SetNumber(*real, Parse<double>(value), settings);
  }
  if (const auto* flag = std::get_if<Flag>(&row.kind)) {
    const auto index = IndexOf(kFlagNames, value);
    if (index) settings.*flag->member = *index == 1;
    return index.has_value();
  }
  if (const auto* choice = std::get_if<Choice>(&row.kind)) {
    const auto index = IndexOf(choice->names, value);
    if (index) choice->write(settings, *index);
    return index.has_value();
  }
  if (std::holds_alternative<MateModel>(row.kind)) return SetMateModel(value, settings);
  return SetModels(value, settings);
}

std::string ModelsText(const SearchSettings& settings) {
  std::array<std::string_view, 3> names;
  std::ranges::transform(settings.opponents, names.begin(), [](OpponentModel model) {
    return kModelNames[static_cast<std::size_t>(model)];
  });
  const bool equal = names[0] == names[1] && names[1] == names[2];
  return equal ? std::string(names[0]) : Joined(names, "/");
}

std::string Get(const OptionRow& row, const SearchSettings& settings) {
  if (const auto* whole = std::get_if<Whole>(&row.kind)) return StrCat(settings.*whole->member);
  if (const auto* real = std::get_if<Real>(&row.kind)) return StrCat(settings.*real->member);
  if (const auto* flag = std::get_if<Flag>(&row.kind)) {
    return std::string(kFlagNames[settings.*flag->member ? 1 : 0]);
  }
  if (const auto* choice = std::get_if<Choice>(&row.kind)) {
    return std::string(choice->names[choice->read(settings)]);
  }
  if (std::holds_alternative<MateModel>(row.kind)) {
    if (!settings.mate_model) return std::string(kMateAsOpponents);
    return std::string(kModelNames[static_cast<std::size_t>(*settings.mate_model)]);
  }
  return ModelsText(settings);
}

SearchSettings PresetFor(std::string_view name) {
  if (name == "default") return {};
  if (name == "paper") return PaperSettings();
  if (name == "gumbel") return GumbelSettings();
  if (name == "katago") return KataGoSettings();
  RefuseValue("preset", name, "default, paper, gumbel or katago");
}

}  // namespace

SearchSettings PaperSettings() {
  SearchSettings settings;
  settings.opponents.fill(OpponentModel::kSimpleUnbiased);
  settings.memory = ModelMemory::kReset;
  settings.exploratory_start = 0.05;
  settings.step_limit = false;
  settings.mate_value_on_death = false;
  settings.tree_reuse = false;
  return settings;
}

SearchSettings GumbelSettings() {
  SearchSettings settings;
  settings.root = RootSearch::kGumbel;
  return settings;
}

SearchSettings KataGoSettings() {
  SearchSettings settings;
  settings.full_search_share = 0.25;
  settings.forced_playouts = 2;
  return settings;
}

void SetOption(SearchSettings& settings, std::string_view name, std::string_view value) {
  if (name == "preset") {
    settings = PresetFor(value);
    return;
  }
  const OptionRow& row = RowOf(name);
  if (!Set(row, value, settings)) RefuseValue(name, value, AllowedFor(row));
}

SearchSettings SearchSettingsFrom(std::span<const std::pair<std::string, std::string>> options) {
  SearchSettings settings;
  for (const auto& [name, value] : options) {
    if (name == "preset") SetOption(settings, name, value);
  }
  for (const auto& [name, value] : options) {
    if (name != "preset") SetOption(settings, name, value);
  }
  return settings;
}

SearchSettings ParseSearchSettings(std::string_view text) {
  std::vector<std::pair<std::string, std::string>> options;
  if (text.empty()) return {};
  for (const std::string_view part : Split(text, ',')) {
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos) {
      throw Error(StrCat("search settings '", text, "': '", part, "' is not name=value"));
    }
    options.emplace_back(part.substr(0, equals), part.substr(equals + 1));
  }
  return SearchSettingsFrom(options);
}

std::vector<SearchOption> ListOptions(const SearchSettings& settings) {
  std::vector<SearchOption> options;
  for (const OptionRow& row : Table()) {
    options.push_back(
        {std::string(row.name), Get(row, settings), StrCat(row.help, " (", AllowedFor(row), ")")});
  }
  return options;
}

std::string ToText(const SearchSettings& settings) {
  const SearchSettings defaults;
  std::string text;
  for (const OptionRow& row : Table()) {
    const std::string value = Get(row, settings);
    if (value == Get(row, defaults)) continue;
    text += StrCat(text.empty() ? "" : ",", row.name, "=", value);
  }
  return text;
}

}  // namespace powderkeg

#include "common/config/players.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>

#include "common/base/check.h"
#include "common/config/run_config.h"

namespace powderkeg {
namespace {

using Weights = PlayerSpec::Weights;
using Teaches = PlayerSpec::Teaches;

constexpr std::array<std::string_view, 3> kTeachesNames = {"nothing", "search", "moves"};
constexpr std::array<std::string_view, 3> kWeightsNames = {"none", "newest", "past"};
constexpr std::string_view kFilePrefix = "file:";
constexpr std::size_t kMostPlayers = 64;  // and line-ups

bool ReadWeights(std::string_view text, const Allowed& /*allowed*/, PlayerSpec& player) {
  const bool file = text.size() > kFilePrefix.size() && text.starts_with(kFilePrefix);
  const auto name = std::ranges::find(kWeightsNames, text);
  if (!file && name == kWeightsNames.end()) return false;
  player.weights = file ? Weights::kFile : static_cast<Weights>(name - kWeightsNames.begin());
  player.weights_file = file ? text.substr(kFilePrefix.size()) : std::string_view();
  return true;
}

std::string WriteWeights(const PlayerSpec& player, const Allowed& /*allowed*/) {
  if (!player.weights) return "";
  if (*player.weights == Weights::kFile) return StrCat(kFilePrefix, player.weights_file);
  return std::string(kWeightsNames[static_cast<std::size_t>(*player.weights)]);
}

// "me, past and the policies idle, ...".
std::string KnownNames(const std::vector<PlayerSpec>& players) {
  std::string names;
  for (const PlayerSpec& player : players) names += player.name + ", ";
  return names + "idle, random, harmless, simple_unbiased, official_simple, pessimist";
}

void CheckName(const std::vector<PlayerSpec>& players, const PlayerSpec& player) {
  const std::string& name = player.name;
  const bool plain =
      !name.empty() && name.size() <= 64 && std::ranges::all_of(name, [](unsigned char c) {
        return std::isalnum(c) != 0 || c == '_' || c == '-';
      });
  const auto refuse = [&](std::string_view expected) {
    throw Error(StrCat("self_play.player.name is ", Quoted(name), "; expected ", expected));
  };
  if (!plain) refuse("1 to 64 characters of [A-Za-z0-9_-]");
  if (IsScript(name)) refuse("another name than a policy's");
  const bool version = name.size() > 1 && name.front() == 'v' &&
                       name.find_first_not_of("0123456789", 1) == std::string::npos;
  if (version) refuse("another name than a version's");
  if (std::ranges::count(players, name, &PlayerSpec::name) > 1) refuse("one player of that name");
}

Player Resolved(const PlayerSpec& spec, const SearchSettings& search) {
  Player player{.name = spec.name,
                .agent = ParsePlayersAgent(spec.agent, search),
                .weights = Weights::kNone,
                .weights_file = spec.weights_file,
                .teaches = spec.teaches};
  const AgentSpec::Kind kind = player.agent.kind;
  const bool has_network = player.agent.HasNetwork();
  player.weights = spec.weights.value_or(has_network ? Weights::kNewest : Weights::kNone);
  const auto refuse = [&](std::string_view what, std::string_view expected) {
    throw Error(StrCat("self_play.player ", spec.name, " (", spec.agent, ") ", what, "; expected ",
                       expected));
  };
  if (!has_network && player.weights != Weights::kNone) refuse("has weights", "none");
  if (kind == AgentSpec::Kind::kRawNetwork && player.weights == Weights::kNone) {
    refuse("has no weights", "newest, past or file:PATH");
  }
  if (player.teaches == Teaches::kSearch && kind != AgentSpec::Kind::kSearch) {
    refuse("teaches search", "teaches: moves, or an agent that searches");
  }
  return player;
}

// The number of the player of that name; a policy joins the players when it is first named.
int NumberOf(const std::string& name, const SelfPlayConfig& config, std::vector<Player>& players) {
  const auto player = std::ranges::find(players, name, &Player::name);
  if (player != players.end()) return static_cast<int>(player - players.begin());
  if (!IsScript(name)) {
    throw Error(StrCat("self_play.lineup.seats names ", Quoted(name), "; expected one of ",
                       KnownNames(config.players)));
  }
  players.push_back({.name = name, .agent = ParseAgent(name)});
  return static_cast<int>(players.size()) - 1;
}

// "me + 3 simple_unbiased": each name once, in the order of the seats.
std::string NameOf(const Words& seats) {
  std::string name;
  for (auto seat = seats.begin(); seat != seats.end(); ++seat) {
    if (std::find(seats.begin(), seat, *seat) != seat) continue;
    const auto count = std::ranges::count(seats, *seat);
    name += StrCat(name.empty() ? "" : " + ", count > 1 ? StrCat(count, " ") : "", *seat);
  }
  return name;
}

Lineup Resolved(const LineupSpec& spec, std::size_t seat_count, const SelfPlayConfig& config,
                std::vector<Player>& players) {
  if (spec.seats.size() != seat_count) {
    throw Error(StrCat("self_play.lineup has ", spec.seats.size(), " seats; expected ", seat_count,
                       " in ", config.environment));
  }
  Lineup lineup{.name = NameOf(spec.seats),
                .share = spec.share,
                .exam = spec.exam,
                .seat_count = static_cast<int>(seat_count)};
  for (std::size_t seat = 0; seat < seat_count; ++seat) {
    lineup.seats[seat] = NumberOf(spec.seats[seat], config, players);
  }
  return lineup;
}

void ShareOut(std::vector<Lineup>& lineups) {
  double sum = 0;
  for (const Lineup& lineup : lineups) sum += lineup.share;
  if (!(sum > 0)) {
    throw Error(StrCat("the shares of self_play.lineup sum to ", sum, "; expected more than 0"));
  }
  for (Lineup& lineup : lineups) lineup.share /= sum;
}

bool Learns(const Players& who) {
  const auto teaches = [&](int player) {
    return who.players[static_cast<std::size_t>(player)].teaches != Teaches::kNothing;
  };
  return std::ranges::any_of(who.lineups, [&](const Lineup& lineup) {
    const auto seats = std::span(lineup.seats).first(static_cast<std::size_t>(lineup.seat_count));
    return lineup.share > 0 && !lineup.exam && std::ranges::any_of(seats, teaches);
  });
}

}  // namespace

Names NamesOf(PlayerSpec::Teaches) { return kTeachesNames; }

OptionTable<PlayerSpec> PlayerOptions() {
  static const std::vector<Option<PlayerSpec>> table = {
      OptionOf<&PlayerSpec::name>("name", kAnything, "unique, for line-ups and results"),
      OptionOf<&PlayerSpec::agent>("agent", kAnything,
                                   "a policy, raw, or search[:OPTION=VALUE,...], whose options "
                                   "change those of self_play.search"),
      {.name = "weights",
       .allowed = kAnything,
       .help = "of its network: the run's newest (default), a past version drawn for every game, "
               "those of a file, or none: the uniform evaluator",
       .read = ReadWeights,
       .write = WriteWeights,
       .expected = [](const Allowed&) { return Joined(kWeightsNames, ", ") + " or file:PATH"; }},
      OptionOf<&PlayerSpec::teaches>("teaches", kAnything,
                                     "what is learned from its seat: nothing, what its search "
                                     "found, or its moves as demonstrations"),
  };
  return table;
}

OptionTable<LineupSpec> LineupOptions() {
  static const std::vector<Option<LineupSpec>> table = {
      OptionOf<&LineupSpec::share>("share", Between(0, 1e6),
                                   "of the games, relative to the other line-ups' shares"),
      OptionOf<&LineupSpec::exam>("exam", kAnything,
                                  "its games are never learned from: the yardstick"),
      OptionOf<&LineupSpec::seats>("seats", kAnything,
                                   "players or policies around the board, turned by every game"),
  };
  return table;
}

GameSettings GameOf(const SelfPlayConfig& config) {
  const std::optional<GameSettings> game = GameSettingsFor(config.environment);
  if (game) return *game;
  throw Error(StrCat("self_play.environment is ", Quoted(config.environment), "; expected one of ",
                     KnownEnvironmentIds()));
}

void FillPlayers(SelfPlayConfig& config) {
  if (!config.lineups.empty() && !config.opponents.empty()) {
    throw Error("self_play.opponents beside self_play.lineup; expected one of the two");
  }
  if (config.players.empty()) config.players.push_back({.name = "me", .teaches = Teaches::kSearch});
  if (config.lineups.empty()) {
    const auto others = static_cast<std::size_t>(SeatCount(GameOf(config).mode) - 1);
    Words names = std::move(config.opponents);
    if (names.empty()) names = {"simple_unbiased"};
    if (names.size() == 1) names.resize(others, names.front());
    if (names.size() < others) {
      throw Error(
          StrCat("self_play.opponents has ", names.size(), " names; expected 1 or ", others));
    }
    names.resize(others);
    names.insert(names.begin(), config.players.front().name);
    config.lineups = {{.share = 0.95, .seats = names},
                      {.share = 0.05, .exam = true, .seats = names}};
  }
  config.opponents.clear();
}

Players ResolvePlayers(const SelfPlayConfig& config) {
  SelfPlayConfig filled = config;
  FillPlayers(filled);
  if (filled.players.size() > kMostPlayers || filled.lineups.size() > kMostPlayers) {
    throw Error(StrCat(filled.players.size(), " players in ", filled.lineups.size(),
                       " line-ups; expected at most ", kMostPlayers));
  }
  Players who;
  for (const PlayerSpec& player : filled.players) {
    CheckName(filled.players, player);
    who.players.push_back(Resolved(player, filled.search));
  }
  const auto seats = static_cast<std::size_t>(SeatCount(GameOf(config).mode));
  for (const LineupSpec& lineup : filled.lineups) {
    who.lineups.push_back(Resolved(lineup, seats, filled, who.players));
  }
  ShareOut(who.lineups);
  if (!Learns(who)) {
    throw Error(
        "nobody teaches: expected a self_play.lineup without exam: true and with a player "
        "whose teaches is search or moves");
  }
  return who;
}

}  // namespace powderkeg

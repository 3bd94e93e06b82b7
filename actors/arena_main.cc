// arena: how strong agents are against given opponents, with intervals.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <iostream>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "actors/arena/contest.h"
#include "actors/arena/match_progress.h"
#include "actors/arena/report.h"
#include "actors/evaluator_choice.h"
#include "actors/play/factory.h"
#include "common/base/check.h"
#include "common/base/processors.h"
#include "common/base/run_main.h"
#include "common/config/agent_spec.h"
#include "common/config/tree_memory.h"
#include "common/model/model_name.h"

namespace powderkeg {
namespace {

constexpr int kMostGames = 1'000'000;

constexpr const char* kExamples = R"(Examples:
  arena --agent search                            # the default search against three SimpleUnbiased
  arena --agent search:model=ffa --games 20       # a trained one (models/ffa.md)
  arena --agent search:model=latest,simulations=64 --games 1000      # the newest of your own
  arena --agent search:model=ffa,tree=two_player,simulations=1000,opponents=simple_unbiased
  arena --agent raw:model=OLD --agent raw:model=NEW --sprt score_difference=0..0.05 --games 5000
  arena --agent search --sprt win_rate=0.5..0.6   # stops when it is clear which of the two it is
  arena --agent search:simulations=50 --models a.weights b.weights c.weights
  arena --agent raw:model=untrained:small:7       # fresh weights of seed 7
  arena --agent search --opponents simple_unbiased search:model=ffa idle
  arena --agent search --mate simple_unbiased --environment PommeTeamCompetition-v0
  arena --agent search:simulations=50 --agent search:simulations=200 --table strength.csv
  arena --agent http:127.0.0.1:10080 --opponents official_simple     # anybody's agent
  deploy/plot-arena strength.csv                  # win rate over simulations, actions, heat maps

The agents sit in every seat in turn, on the same boards for each --agent. Elo is over the average
opponent; in a free-for-all equal agents (who win 1 in 4) are 0 apart. Intervals are 95 %.
Depth is the mean over simulations, variation the length of the principal variation, both in steps of
the game. ms/move includes the whole game, on one thread; of one game alone: --threads 1
--games-in-flight 1.

http:HOST:PORT is a server of the official agent protocol, in any language, and arena its runner: it
waits 150 ms for a move, then plays stop and says how often. A server plays one game at a time and
has one seat; what the official runner would stop at stops the match with one line.

--sprt FIGURE=LOW..HIGH asks whether the figure is LOW or HIGH and plays until that is answered
(Wald's test; each answer wrong in 5 % at most) or --games are played:
  win_rate=0.5..0.6           of each --agent
  score_difference=0..0.05    of the second --agent over the first, board by board, in points per
                              game (win 1, tie 1/2, loss 0)
)";

struct Arguments {
  std::vector<std::string> agents;
  std::vector<std::string> models;
  std::vector<std::string> opponents = {"simple_unbiased"};
  std::string mate;  // empty: the agent itself
  std::string environment = "PommeFFACompetition-v0";
  std::string board = "official";
  std::string corners = "permuted";
  EvaluatorChoice evaluator;
  int games = 200;
  std::string question;
  int min_games = 100;
  std::uint64_t seed = 1;
  int threads = UsableProcessors();
  int games_in_flight = 0;
  std::string json_file;
  std::string table_file;
  std::string csv_file;
  std::string position_file = MatchSettings().position_file;
};

void AddPlayers(CLI::App& app, Arguments& arguments) {
  app.add_option("--agent", arguments.agents,
                 "agent to measure; several are measured on the same boards and compared with the "
                 "first. " +
                     KnownAgents() + ". MODEL is " + kModelHelp)
      ->required()
      ->expected(1)
      ->take_all();
  app.add_option("--models", arguments.models,
                 "each --agent, which names no model, is measured with each of these: mean and "
                 "standard deviation between models too");
  app.add_option("--opponents", arguments.opponents,
                 "the other agents: one for all, or one for each seat after the measured one")
      ->expected(1, 3);
  app.add_option("--mate", arguments.mate,
                 "in team modes: who plays with the measured agent; without it, the agent itself");
  app.add_option("--evaluator", arguments.evaluator.evaluator,
                 "of agents with a model: " + Joined(kEvaluatorNames, ", "));
  app.add_option("--precision", arguments.evaluator.precision, Joined(kPrecisionNames, ", "));
  app.add_flag_callback(
      "--help-options",
      [] {
        std::cout << AgentOptionsHelp();
        throw CLI::Success();
      },
      "every option of a search with its default, meaning and range");
}

void AddGames(CLI::App& app, Arguments& arguments) {
  app.add_option("--environment", arguments.environment, KnownEnvironmentIds());
  app.add_option("--board", arguments.board)->check(CLI::IsMember({"official", "uniform"}));
  app.add_option("--corners", arguments.corners)->check(CLI::IsMember({"official", "permuted"}));
  app.add_option("--games", arguments.games, "of each agent, at most")
      ->check(CLI::Range(1, kMostGames));
  app.add_option("--sprt", arguments.question, "question that ends the match early; see below");
  app.add_option("--min-games", arguments.min_games, "no answer to it before so many")
      ->check(CLI::Range(1, kMostGames));
  app.add_option("--seed", arguments.seed, "equal seeds give equal boards");
  app.add_option("--threads", arguments.threads)->check(CLI::Range(1, 1024));
  app.add_option("--games-in-flight", arguments.games_in_flight,
                 "games side by side on each thread, which fill the batches of networks; 0: 16 "
                 "where an agent has a model, else 1")
      ->check(CLI::Range(0, 4096));
}

void AddOutputs(CLI::App& app, Arguments& arguments) {
  app.add_option("--json", arguments.json_file, "write the result to this file");
  app.add_option("--table", arguments.table_file,
                 "write one line per agent as CSV to this file; deploy/plot-arena draws it");
  app.add_option("--csv", arguments.csv_file, "write one line per game to this file");
  app.add_option("--position-file", arguments.position_file,
                 "where the position goes if a network answers with something that is no number");
}

void Describe(CLI::App& app, Arguments& arguments) {
  AddPlayers(app, arguments);
  AddGames(app, arguments);
  AddOutputs(app, arguments);
  app.footer(kExamples);
}

ContestSettings SettingsOf(const Arguments& arguments) {
  const std::optional<GameSettings> game = GameSettingsFor(arguments.environment);
  if (!game) {
    throw Error(StrCat("environment \"", arguments.environment, "\": expected one of ",
                       KnownEnvironmentIds()));
  }
  ContestSettings settings;
  settings.match.game = *game;
  settings.match.start.generator =
      arguments.board == "uniform" ? BoardGenerator::kUniform : BoardGenerator::kOfficial;
  settings.match.start.corners =
      arguments.corners == "official" ? StartCorners::kOfficial : StartCorners::kPermuted;
  settings.match.seed = arguments.seed;
  settings.match.games = arguments.games;
  settings.match.threads = std::min(arguments.threads, arguments.games);
  settings.match.games_in_flight = arguments.games_in_flight;
  settings.match.position_file = arguments.position_file;
  if (!arguments.question.empty()) settings.question = ParseQuestion(arguments.question);
  settings.min_games = arguments.min_games;
  return settings;
}

// --agent with --models: one with each.
struct Measured {
  std::string agent;
  std::string settings;  // Contender::settings
};

std::vector<Measured> MeasuredAgents(const Arguments& arguments) {
  std::vector<Measured> measured;
  for (const std::string& agent : arguments.agents) {
    if (arguments.models.empty()) measured.push_back({agent, ""});
    const char separator = agent.find(':') == std::string::npos ? ':' : ',';
    for (const std::string& model : arguments.models) {
      if (agent.find("model=") != std::string::npos) {
        throw Error(StrCat("--agent ", agent, " names a model beside --models; expected none"));
      }
      measured.push_back({StrCat(agent, separator, "model=", model), agent});
    }
  }
  return measured;
}

// The agent in role 0 and, in team modes, its mate in role 2.
MatchLineup LineupOf(const std::string& agent, const Arguments& arguments, Mode mode) {
  MatchLineup lineup;
  lineup[0] = AgentFor(agent);
  for (std::size_t role = 1; role < lineup.size(); ++role) {
    const std::vector<std::string>& opponents = arguments.opponents;
    lineup[role] = AgentFor(opponents[std::min(role, opponents.size()) - 1]);
  }
  if (IsTeamMode(mode)) {
    lineup[2] = arguments.mate.empty() ? lineup[0] : AgentFor(arguments.mate);
  } else if (!arguments.mate.empty()) {
    throw Error(StrCat("--mate ", arguments.mate, ": ", arguments.environment,
                       " has no mates: expected a team environment"));
  }
  CheckServers(std::span(lineup).first(static_cast<std::size_t>(SeatCount(mode))));
  return lineup;
}

ModelLoader LoaderOf(const EvaluatorChoice& choice) {
  return [choice](const std::string& file) -> Model {
    const Snapshot snapshot = LoadModel(file);
    return {MakeEvaluator(choice, snapshot), snapshot->version};
  };
}

std::string Joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : " ") + part;
  return text;
}

// A progress bar for each agent on stderr.
class Bars final : public ContestWatcher {
 public:
  Bars(const std::vector<MatchLineup>& lineups, int games) {
    const auto style =
        isatty(STDERR_FILENO) != 0 ? MatchProgress::Style::kTerminal : MatchProgress::Style::kPlain;
    for (const MatchLineup& lineup : lineups) {
      bars_.emplace_back(std::cerr, style, lineup[0].text, games);
    }
  }

  void Began(int agent) override { bars_[agent].Start(MatchProgress::Clock::now()); }
  void Played(int agent, const PlayedGame& game) override {
    bars_[agent].AddGame(game, MatchProgress::Clock::now());
  }
  void Tested(int agent, const TestState& state) override { bars_[agent].SetTest(state); }
  void Paused(int agent) override { bars_[agent].Pause(MatchProgress::Clock::now()); }

 private:
  std::vector<MatchProgress> bars_;
};

std::vector<Contender> ContendersOf(const Arguments& arguments,
                                    const std::vector<Measured>& measured,
                                    const MatchSettings& settings,
                                    const std::vector<MatchLineup>& lineups,
                                    std::vector<ContestResult> results) {
  std::vector<Contender> contenders;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const AgentSpec& agent = lineups[i][0];
    const bool searches = agent.kind == AgentSpec::Kind::kSearch;
    Contender contender{.agent = agent.text,
                        .opponents = Joined(arguments.opponents),
                        .simulations = searches ? agent.search.simulations : 0,
                        .match = std::move(results[i].match),
                        .test = results[i].test,
                        .summary = {},
                        .difference = {},
                        .teams = IsTeamMode(settings.game.mode),
                        .settings = measured[i].settings};
    for (int role = 0; role < SeatCount(settings.game.mode); ++role) {
      contender.roles[role] = lineups[i][role].text;
    }
    if (!arguments.mate.empty()) contender.opponents += ", with mate " + arguments.mate;
    contender.summary = Summarize(settings, contender.match);
    if (i > 0) contender.difference = Compare(settings, contender.match, contenders[0].match);
    contenders.push_back(std::move(contender));
  }
  return contenders;
}

void WriteFile(const std::string& path, const std::string& text) {
  if (path.empty()) return;
  std::ofstream file(path);
  file << text << std::flush;
  if (!file) throw Error(StrCat("cannot write \"", path, "\""));
}

int Run(const Arguments& arguments) {
  const ContestSettings settings = SettingsOf(arguments);
  const std::vector<Measured> measured = MeasuredAgents(arguments);
  std::vector<MatchLineup>
      lineups;  // all at once: a mistake should not surface after the first match
  for (const Measured& each : measured) {
    lineups.push_back(LineupOf(each.agent, arguments, settings.match.game.mode));
    RequireMemoryForTrees(each.agent, TreeBytes(lineups.back(), settings.match));
  }
  InitialiseEvaluators();
  Bars bars(lineups, arguments.games);
  std::vector<ContestResult> results =
      PlayContest(lineups, settings, LoaderOf(arguments.evaluator), bars);
  const std::vector<Contender> contenders =
      ContendersOf(arguments, measured, settings.match, lineups, std::move(results));
  std::cout << ReportText(contenders);
  WriteFile(arguments.json_file, ReportJson(contenders));
  WriteFile(arguments.table_file, TableCsv(contenders));
  WriteFile(arguments.csv_file, GamesCsv(contenders));
  return kDone;
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  CLI::App app("Measures agents: win, tie and loss rates with 95 % intervals.", "arena");
  powderkeg::Arguments arguments;
  powderkeg::Describe(app, arguments);
  return powderkeg::RunMain(app, argc, argv, [&] { return powderkeg::Run(arguments); });
}

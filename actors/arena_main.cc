// arena: how strong agents are against given opponents, with intervals.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <iostream>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "actors/arena/match.h"
#include "actors/arena/progress.h"
#include "actors/arena/report.h"
#include "actors/evaluator_choice.h"
#include "actors/play/factory.h"
#include "common/base/check.h"
#include "common/model/weights_snapshot.h"

namespace powderkeg {
namespace {

struct Arguments {
  std::vector<std::string> agents;
  std::vector<std::string> opponents = {"simple_unbiased"};
  std::string environment = "PommeFFACompetition-v0";
  std::string board = "official";
  std::string corners = "permuted";
  EvaluatorChoice evaluator;
  int games = 200;
  std::uint64_t seed = 1;
  int threads = static_cast<int>(std::thread::hardware_concurrency());
  int games_in_flight = 0;  // 0: see GamesInFlight
  std::string json_file;
  std::string csv_file;
};

void AddOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("--agent", arguments.agents,
                 "agent to measure; several are measured on the same boards and compared with the "
                 "first. " +
                     KnownAgents())
      ->required()
      ->expected(1)
      ->take_all();
  app.add_option("--opponents", arguments.opponents,
                 "the other agents: one for all, or one for each seat after the measured one")
      ->expected(1, 3);
  app.add_option("--environment", arguments.environment, KnownEnvironmentIds());
  app.add_option("--board", arguments.board)->check(CLI::IsMember({"official", "uniform"}));
  app.add_option("--corners", arguments.corners)->check(CLI::IsMember({"official", "permuted"}));
  app.add_option("--evaluator", arguments.evaluator.evaluator,
                 "of agents with a model: auto, uniform, onednn, torch");
  app.add_option("--precision", arguments.evaluator.precision, "auto, fp32, bf16, fp16");
  app.add_option("--games", arguments.games)->check(CLI::PositiveNumber);
  app.add_option("--seed", arguments.seed, "equal seeds give equal boards");
  app.add_option("--threads", arguments.threads)->check(CLI::PositiveNumber);
  app.add_option("--games-in-flight", arguments.games_in_flight,
                 "games side by side on each thread, which fill the batches of networks; 0: 16 "
                 "where an agent has a model, else 1")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--json", arguments.json_file, "write the result to this file");
  app.add_option("--csv", arguments.csv_file, "write one line per game to this file");
  app.option_defaults()->always_capture_default();
}

// Without a network, games side by side only crowd the caches.
int GamesInFlight(const Arguments& arguments, const Lineup& lineup) {
  if (arguments.games_in_flight > 0) return arguments.games_in_flight;
  constexpr int kWithModel = 16;
  return std::ranges::all_of(lineup, &std::string::empty, &AgentDescription::model_file)
             ? 1
             : kWithModel;
}

MatchSettings SettingsOf(const Arguments& arguments) {
  const std::optional<GameSettings> game = GameSettingsFor(arguments.environment);
  if (!game) {
    throw Error(StrCat("environment \"", arguments.environment, "\": expected one of ",
                       KnownEnvironmentIds()));
  }
  MatchSettings settings;
  settings.game = *game;
  settings.start.generator =
      arguments.board == "uniform" ? BoardGenerator::kUniform : BoardGenerator::kOfficial;
  settings.start.corners =
      arguments.corners == "official" ? StartCorners::kOfficial : StartCorners::kPermuted;
  settings.seed = arguments.seed;
  settings.games = arguments.games;
  settings.threads = std::min(arguments.threads, arguments.games);
  return settings;
}

// The agent in role 0 and, in team modes, as its own mate in role 2.
Lineup LineupOf(const std::string& agent, const Arguments& arguments, Mode mode) {
  Lineup lineup;
  lineup[0] = ParseAgent(agent);
  for (std::size_t role = 1; role < lineup.size(); ++role) {
    const std::vector<std::string>& opponents = arguments.opponents;
    lineup[role] = ParseAgent(opponents[std::min(role, opponents.size()) - 1]);
  }
  if (IsTeamMode(mode)) lineup[2] = lineup[0];
  return lineup;
}

ModelLoader LoaderOf(const EvaluatorChoice& choice) {
  return [choice](const std::string& file) -> Model {
    const Snapshot snapshot = LoadSnapshot(file);
    return {MakeEvaluator(choice, snapshot), snapshot->version};
  };
}

std::string Joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : " ") + part;
  return text;
}

Contender Measure(const std::string& agent, const Arguments& arguments, MatchSettings settings) {
  const Lineup lineup = LineupOf(agent, arguments, settings.game.mode);
  settings.games_in_flight = GamesInFlight(arguments, lineup);
  const bool terminal = isatty(STDERR_FILENO) != 0;
  Progress progress(std::cerr, terminal ? Progress::Style::kTerminal : Progress::Style::kPlain,
                    agent, settings.games, Progress::Clock::now());
  Contender contender{agent, Joined(arguments.opponents), {}, {}};
  contender.match = PlayMatch(
      lineup, settings, LoaderOf(arguments.evaluator),
      [&progress](const PlayedGame& game) { progress.AddGame(game, Progress::Clock::now()); });
  progress.Finish();
  contender.summary = Summarize(settings, contender.match);
  return contender;
}

void WriteFile(const std::string& path, const std::string& text) {
  if (path.empty()) return;
  std::ofstream file(path);
  file << text << std::flush;
  if (!file) throw Error(StrCat("cannot write \"", path, "\""));
}

void Run(const Arguments& arguments) {
  const MatchSettings settings = SettingsOf(arguments);
  // A wrong specification should not surface after the first match.
  for (const std::string& agent : arguments.agents) {
    (void)LineupOf(agent, arguments, settings.game.mode);
  }
  InitialiseEvaluators();
  std::vector<Contender> contenders;
  for (const std::string& agent : arguments.agents) {
    contenders.push_back(Measure(agent, arguments, settings));
  }
  std::cout << ReportText(contenders);
  WriteFile(arguments.json_file, ReportJson(contenders));
  WriteFile(arguments.csv_file, ReportCsv(contenders));
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  CLI::App app("Measures agents: win, tie and loss rates with 95 % intervals.", "arena");
  powderkeg::Arguments arguments;
  powderkeg::AddOptions(app, arguments);
  CLI11_PARSE(app, argc, argv);
  try {
    powderkeg::Run(arguments);
  } catch (const powderkeg::Error& error) {
    std::cerr << "arena: " << error.what() << "\n";
    return 1;
  }
  return 0;
}

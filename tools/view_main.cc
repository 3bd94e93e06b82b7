// view: games in the browser, to look at and to play.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <iostream>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "actors/evaluator_choice.h"
#include "common/base/check.h"
#include "common/base/log.h"
#include "common/base/run_main.h"
#include "common/model/model_name.h"
#include "tools/board/board_routes.h"

namespace powderkeg {
namespace {

constexpr const char* kUsualAddress = "127.0.0.1:8266";

constexpr const char* kExamples = R"(Examples:
  view runs/quick                                  # the games of a run, by version and line-up
  view runs/quick/replay/segment-00000012.h5
  view tests/data/ffa.jsonl.gz                     # recorded games
  view --play                                      # you against three SimpleUnbiased
  view --play --opponents search:simulations=100,model=ffa
)";

struct Arguments {
  std::string source;
  bool play = false;
  std::vector<std::string> opponents = {"simple_unbiased"};
  std::string adviser = "search:simulations=200";
  std::string model;
  std::string environment = "PommeFFACompetition-v0";
  std::optional<std::uint64_t> seed;
  EvaluatorChoice evaluator;
  std::string http;  // empty: kUsualAddress or, where that is taken, any free port
};

void Describe(CLI::App& app, Arguments& arguments) {
  app.add_option("source", arguments.source,
                 "a run's folder, a segment of it (replay/segment-*.h5) or recorded games (.jsonl, "
                 ".jsonl.gz)");
  CLI::Option* const play =
      app.add_flag("--play", arguments.play, "a person in seat 0 plays against agents");
  app.add_option("--opponents", arguments.opponents,
                 "the other agents: one for all, or one for each seat. " + KnownAgents())
      ->expected(1, kAgentCount - 1)
      ->needs(play);
  app.add_option("--hints", arguments.adviser, "the search that advises the person")->needs(play);
  app.add_option("--model", arguments.model, StrCat("of agents that name none: ", kModelHelp))
      ->needs(play);
  app.add_option("--environment", arguments.environment,
                 StrCat("of the games to play: ", KnownEnvironmentIds()))
      ->needs(play);
  app.add_option("--seed", arguments.seed, "of the games to play; without it, any")->needs(play);
  app.add_option("--http", arguments.http,
                 StrCat("address and port to serve at (", kUsualAddress,
                        " or, where that is taken, any free port)"));
  app.footer(kExamples);
}

PlaySettings PlaySettingsOf(const Arguments& arguments) {
  const std::optional<GameSettings> game = GameSettingsFor(arguments.environment);
  if (!game) {
    throw Error(StrCat("environment \"", arguments.environment, "\": expected one of ",
                       KnownEnvironmentIds()));
  }
  PlaySettings settings;
  settings.game = *game;
  for (std::size_t i = 0; i < settings.opponents.size(); ++i) {
    const std::size_t given = std::min(i, arguments.opponents.size() - 1);
    settings.opponents[i] = AgentFor(arguments.opponents[given], arguments.model);
  }
  CheckServers(
      std::span(settings.opponents).first(static_cast<std::size_t>(SeatCount(game->mode) - 1)));
  settings.adviser = AgentFor(arguments.adviser, arguments.model);
  if (settings.adviser.kind != AgentSpec::Kind::kSearch) {
    throw Error(StrCat("--hints ", arguments.adviser, ": expected a search"));
  }
  settings.loader = [choice = arguments.evaluator](const std::string& file) -> Model {
    const Snapshot snapshot = LoadModel(file);
    return {MakeEvaluator(choice, snapshot), snapshot->version};
  };
  settings.seed = arguments.seed ? *arguments.seed : std::random_device()();
  return settings;
}

HttpServerSettings ServerOf(const std::string& http) {
  const std::optional<HttpAddress> address = ParseHttpAddress(http.empty() ? kUsualAddress : http);
  if (!address) {
    throw Error(
        StrCat("--http is '", http, "', expected ADDRESS:PORT with a port from 0 to 65535"));
  }
  HttpServerSettings settings;
  settings.address = *address;
  settings.any_port_if_taken = http.empty();
  settings.threads = 4;
  settings.max_waiting = 64;
  settings.max_request_bytes = 1024;
  settings.io_timeout = std::chrono::seconds(10);  // for a whole game through a slow tunnel
  return settings;
}

int Run(const Arguments& arguments) {
  if (arguments.source.empty() && !arguments.play) {
    throw Error("expected games to look at, or --play; see --help");
  }
  std::signal(SIGPIPE, SIG_IGN);
  log::Init(/*file=*/"", log::LevelFor("warn"));
  std::optional<GameLibrary> library;
  if (!arguments.source.empty()) library.emplace(arguments.source);
  std::optional<PlayRoom> room;
  if (arguments.play) {
    InitialiseEvaluators();
    room.emplace(PlaySettingsOf(arguments));
  }
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  const HttpServer server(BoardRoutes(library ? &*library : nullptr, room ? &*room : nullptr),
                          ServerOf(arguments.http));
  std::cout << "view: " << server.address().url() << "  (Ctrl-C ends)" << std::endl;
  int signal = 0;
  sigwait(&signals, &signal);
  return kDone;
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  CLI::App app("Shows games in the browser: stored ones, and a person against agents.", "view");
  powderkeg::Arguments arguments;
  powderkeg::Describe(app, arguments);
  return powderkeg::RunMain(app, argc, argv, [&] { return powderkeg::Run(arguments); });
}

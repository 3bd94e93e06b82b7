// agent_server: serves agents to the official runner over HTTP, one on each port.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "actors/evaluator_choice.h"
#include "actors/http/agent_routes.h"
#include "actors/http/agent_service.h"
#include "actors/play/factory.h"
#include "common/base/check.h"
#include "common/base/descriptors.h"
#include "common/base/log.h"
#include "common/base/processors.h"
#include "common/base/run_main.h"
#include "common/config/agent_spec.h"
#include "common/config/tree_memory.h"
#include "common/http/http_server.h"
#include "common/model/evaluation_cache.h"
#include "common/model/model_name.h"

namespace powderkeg {
namespace {

// Under a clock: simulations that no move reaches, and leaves that keep a thread busy for about a
// millisecond of the published network.
constexpr int kEnoughSimulations = 20'000;
constexpr int kLeavesPerThread = 4;
// Of a Gumbel root, as nobody knows how many simulations there will be.
constexpr int kFirstHalving = 64;

// More threads than this share the leaves of one search badly.
constexpr int kMostThreads = 4;

struct Arguments {
  std::vector<std::string> agents;
  std::vector<int> ports = {10080};
  std::string host = "127.0.0.1";
  std::string model;
  int simulations = 0;   // 0: as the agent says
  int move_time_ms = 0;  // 0: no clock
  std::uint64_t seed = 1;
  std::string log_level = "info";
  EvaluatorChoice evaluator{.threads = std::min(UsableProcessors(), kMostThreads)};
};

void AddOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("--agent", arguments.agents, "one for all ports or one for each: " + KnownAgents())
      ->required();
  app.add_option("--port", arguments.ports, "one or more")->check(CLI::Range(1, 65535));
  app.add_option("--host", arguments.host, "address to listen on; 0.0.0.0: all");
  app.add_option("--model", arguments.model, StrCat("of agents that name none: ", kModelHelp));
  auto* simulations = app.add_option("--simulations", arguments.simulations, "of a search per move")
                          ->check(CLI::Range(1, 1'000'000));
  app.add_option("--move-time-ms", arguments.move_time_ms,
                 "a search answers after so long at the latest; the official runner waits 150 ms")
      ->check(CLI::Range(1, 3'600'000))
      ->excludes(simulations);
  app.add_option("--seed", arguments.seed, "of all random choices");
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
  app.add_option("--evaluator-threads", arguments.evaluator.threads,
                 "processors that answer the questions of a search, each part of them; only with "
                 "onednn")
      ->check(CLI::Range(1, 64));
  app.add_option("--cache-mb", arguments.evaluator.cache_mb,
                 "memory for answers given before; 0: none")
      ->check(CLI::Range(0, 4096));
  app.add_option("--log-level", arguments.log_level,
                 "debug (also names every move cut short or over 100 ms), info, warn or error");
}

// The agent's own words, changed by what holds for all.
AgentSpec DescriptionOf(const std::string& text, const Arguments& arguments) {
  AgentSpec description = AgentFor(text, arguments.model);
  if (description.kind == AgentSpec::Kind::kForeign) {
    throw Error(StrCat("--agent ", text, ": expected an agent that is no server itself"));
  }
  if (arguments.simulations > 0) description.search.simulations = arguments.simulations;
  if (arguments.move_time_ms > 0) {
    description.search.simulations = kEnoughSimulations;
    description.search.leaves_per_batch = std::max(description.search.leaves_per_batch,
                                                   kLeavesPerThread * arguments.evaluator.threads);
    if (description.search.gumbel_first_halving == 0) {
      description.search.gumbel_first_halving = kFirstHalving;
    }
  }
  return description;
}

// Refuses options that no agent would look at.
void CheckOptions(const std::vector<AgentSpec>& agents, const Arguments& arguments) {
  using Kind = AgentSpec::Kind;
  const bool searches = std::ranges::any_of(
      agents, [](const AgentSpec& agent) { return agent.kind == Kind::kSearch; });
  const bool thinks = std::ranges::any_of(agents, &AgentSpec::HasNetwork);
  if (!searches && (arguments.simulations > 0 || arguments.move_time_ms > 0)) {
    throw Error("--simulations and --move-time-ms: expected an agent that searches");
  }
  if (!thinks && !arguments.model.empty()) {
    throw Error(StrCat("--model ", arguments.model, ": expected an agent with a network"));
  }
}

// One for each port.
std::vector<AgentSpec> AgentsOf(const Arguments& arguments) {
  const std::size_t ports = arguments.ports.size();
  if (arguments.agents.size() != 1 && arguments.agents.size() != ports) {
    throw Error(StrCat(arguments.agents.size(), " agents for ", ports,
                       " ports, expected one agent or one for each port"));
  }
  std::vector<AgentSpec> agents;
  for (const std::string& text : arguments.agents) {
    agents.push_back(DescriptionOf(text, arguments));
  }
  CheckOptions(agents, arguments);
  agents.resize(ports, agents.front());
  return agents;
}

// An agent on a port. The order matters: the server uses the service.
struct Seat {
  std::shared_ptr<Evaluator> evaluator;
  std::unique_ptr<AgentService> service;
  std::unique_ptr<HttpServer> server;
};

// Under a clock everything is ready before the first game.
Seat Serve(const AgentSpec& agent, int port, const Arguments& arguments) {
  const bool timed = arguments.move_time_ms > 0;
  EvaluatorChoice choice = arguments.evaluator;
  // For as many questions about models as about leaves.
  if (timed) choice.largest_batch = 2 * agent.search.leaves_per_batch;
  const Model model = MakeModel(agent.model_file, [&](const std::string& file) -> Model {
    const Snapshot snapshot = LoadModel(file);
    return {MakeEvaluator(choice, snapshot), snapshot->version};
  });
  Seat seat;
  seat.evaluator = model.evaluator;
  seat.service = std::make_unique<AgentService>(
      MakeAgent(agent), model.evaluator,
      ServiceSettings{.move_time = std::chrono::milliseconds(arguments.move_time_ms),
                      .seed = arguments.seed});
  if (timed) seat.service->WarmUp();
  seat.server = std::make_unique<HttpServer>(
      AgentRoutes(*seat.service),
      HttpServerSettings{.address = {.host = arguments.host, .port = port}});
  log::Info("serving", "agent", agent.text, "evaluator", model.evaluator->name(), "host",
            arguments.host, "port", seat.server->address().port);
  return seat;
}

// From here on these signals wait for sigwait, in all threads.
sigset_t BlockEndSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

double Milliseconds(std::chrono::microseconds time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

void Report(const Seat& seat) {
  const int port = seat.server->address().port;
  const ServiceStatistics served = seat.service->statistics();
  const MoveTimes& slowest = served.slowest_move;
  log::Info("served", "port", port, "games", served.games, "moves", served.moves, "refused",
            served.refused, "cut_short", served.cut_short, "stand_ins", served.stand_ins,
            "over_100_ms", served.late_moves);
  log::Info("slowest move", "port", port, "ms", Milliseconds(slowest.total()), "read_ms",
            Milliseconds(slowest.read), "wait_ms", Milliseconds(slowest.wait), "think_ms",
            Milliseconds(slowest.think));
  if (served.searches == 0) return;
  log::Info("searched", "port", port, "simulations_per_search",
            served.simulations / served.searches, "questions_per_search",
            served.evaluations / served.searches);
  const auto* const cache = dynamic_cast<const EvaluationCache*>(seat.evaluator.get());
  if (cache == nullptr || cache->misses() == 0) return;
  const auto hits = static_cast<double>(cache->hits());
  log::Info("cache", "port", port, "hit_share",
            hits / (hits + static_cast<double>(cache->misses())), "evaluations_per_search",
            cache->misses() / served.searches);
}

int Run(const Arguments& arguments) {
  const std::vector<AgentSpec> agents = AgentsOf(arguments);
  const sigset_t signals = BlockEndSignals();
  AllowManyDescriptors();
  std::signal(SIGPIPE, SIG_IGN);
  log::Init(/*file=*/"", log::LevelFor(arguments.log_level));
  std::size_t tree_bytes = 0;
  for (const AgentSpec& agent : agents) tree_bytes += TreeBytes(agent);
  RequireMemoryForTrees("these agents", tree_bytes);
  InitialiseEvaluators();
  std::vector<Seat> seats;
  for (std::size_t i = 0; i < agents.size(); ++i) {
    seats.push_back(Serve(agents[i], arguments.ports[i], arguments));
  }
  int signal = 0;
  sigwait(&signals, &signal);
  for (const Seat& seat : seats) Report(seat);
  return kDone;
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  CLI::App app("Serves agents to the official Pommerman runner over HTTP.", "agent_server");
  powderkeg::Arguments arguments;
  powderkeg::AddOptions(app, arguments);
  return powderkeg::RunMain(app, argc, argv, [&] { return powderkeg::Run(arguments); });
}

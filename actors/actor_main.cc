// actor: plays games for a learner.

#include <signal.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>

#include "actors/evaluator_choice.h"
#include "actors/selfplay/self_play.h"
#include "common/base/check.h"
#include "common/base/descriptors.h"
#include "common/base/log.h"
#include "common/base/name.h"
#include "common/base/processors.h"
#include "common/base/run_main.h"
#include "common/base/unique.h"
#include "common/base/worker.h"
#include "common/wire/zmq_transport.h"

namespace powderkeg {
namespace {

struct Arguments {
  std::string learner;
  std::string name;
  std::uint32_t loops = static_cast<std::uint32_t>(UsableProcessors());
  std::string spool;
  std::string keys;
  std::string run_id;
  std::string evaluator;
  std::string precision;
  std::string log_file;
  std::string log_level = "info";
  int patience_s = 10;
  int give_up_s = 0;
};

// EX_TEMPFAIL of sysexits.h: the same again, later, may work.
constexpr int kGaveUp = 75;

void AddOptions(CLI::App& app, Arguments& arguments) {
  arguments.name = HostName().empty() ? "actor" : HostName();
  app.add_option("--learner", arguments.learner, "tcp://HOST:PORT or ipc://PATH")->required();
  app.add_option("--name", arguments.name, "unique in the run");
  app.add_option("--loops", arguments.loops, "threads that play")->check(CLI::Range(1u, kMaxLoops));
  app.add_option("--spool", arguments.spool,
                 "folder for games that are not acknowledged; one for each actor")
      ->required();
  app.add_option("--keys", arguments.keys,
                 "folder with learner.public and actors/NAME.{public,secret}");
  app.add_option("--run", arguments.run_id, "refuse to play for any other run");
  app.add_option("--evaluator", arguments.evaluator,
                 Joined(kEvaluatorNames, ", ") + " instead of what the run says");
  app.add_option("--precision", arguments.precision,
                 Joined(kPrecisionNames, ", ") + " instead of what the run says");
  app.add_option("--log-file", arguments.log_file, "beside standard error");
  app.add_option("--log-level", arguments.log_level, "debug, info, warn or error");
  app.add_option("--patience", arguments.patience_s,
                 "seconds that the end waits for games to be acknowledged")
      ->check(CLI::Range(0, 3600));
  app.add_option("--give-up", arguments.give_up_s,
                 "seconds without the learner after which it ends with code 75; 0: never")
      ->check(CLI::Range(0, 86'400));
}

SelfPlaySettings SettingsOf(const Arguments& arguments) {
  SelfPlaySettings settings;
  settings.session.run_id = arguments.run_id;
  settings.session.build = std::string("powderkeg ") + Version();
  settings.session.name = arguments.name;
  settings.session.incarnation = UniqueNumber();
  settings.session.loops = arguments.loops;
  settings.session.give_up = std::chrono::seconds(arguments.give_up_s);
  settings.spool = arguments.spool;
  settings.patience = std::chrono::seconds(arguments.patience_s);
  return settings;
}

Connect ConnectorOf(const Arguments& arguments) {
  std::optional<ClientKeys> keys;
  if (!arguments.keys.empty()) keys = ReadClientKeys(arguments.keys, arguments.name);
  return [endpoint = arguments.learner, keys] { return ConnectZmq(endpoint, keys); };
}

// What the operator says goes before what the run says.
EvaluatorFactory FactoryOf(const Arguments& arguments) {
  return [arguments](const SelfPlayConfig& config, const Snapshot& weights) {
    const EvaluatorChoice choice{
        .evaluator = arguments.evaluator.empty() ? config.evaluator : arguments.evaluator,
        .precision = arguments.precision.empty() ? config.precision : arguments.precision};
    return MakeEvaluator(choice, weights);
  };
}

// Until it ends by itself or by SIGINT or SIGTERM. `signals` must be blocked.
void RunUntilSignal(SelfPlay& self_play, const sigset_t& signals) {
  Worker worker("actor", [&](const std::stop_token& stop) { self_play.Run(stop); });
  const timespec poll{.tv_sec = 0, .tv_nsec = 200'000'000};
  while (!worker.finished()) {
    if (sigtimedwait(&signals, nullptr, &poll) > 0) {
      log::Info("stopping");
      worker.RequestStop();
    }
  }
  worker.Join();
}

int Play(const Arguments& arguments) {
  RequireName("--name", arguments.name);
  AllowManyDescriptors();
  signal(SIGPIPE, SIG_IGN);
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);  // every thread inherits it
  log::Init(arguments.log_file, log::LevelFor(arguments.log_level));
  InitialiseEvaluators();
  SelfPlay self_play(SettingsOf(arguments), ConnectorOf(arguments), FactoryOf(arguments));
  RunUntilSignal(self_play, signals);
  if (self_play.gave_up()) return kGaveUp;
  log::Info("done");
  return kDone;
}

int Run(const Arguments& arguments) {
  try {
    return Play(arguments);
  } catch (const std::exception& error) {
    log::Error("actor failed", "error", error.what());
    return kFailed;
  }
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  powderkeg::Arguments arguments;
  CLI::App app("Plays games for a learner until told to stop.", "actor");
  powderkeg::AddOptions(app, arguments);
  if (const auto code = powderkeg::ReadCommandLine(app, argc, argv)) return *code;
  return powderkeg::Run(arguments);
}

// The learner: takes games in, trains, hands weights out, until the run's iterations are done.

#include <CLI/CLI.hpp>
#include <csignal>
#include <exception>
#include <filesystem>
#include <iostream>
#include <string>

#include "common/base/descriptors.h"
#include "common/base/log.h"
#include "common/base/run_main.h"
#include "common/config/config.h"
#include "common/model/model_name.h"
#include "learner/report/dashboard.h"
#include "learner/run/learner.h"
#include "learner/run/run_folder.h"

namespace powderkeg {
namespace {

volatile std::sig_atomic_t stop_signal = 0;

struct Options {
  LearnerSettings learner;
  std::string http = "off";
  std::string log_level = "info";
  bool check = false;
};

void AddOptions(CLI::App& app, Options& options) {
  options.learner.listen = "tcp://127.0.0.1:5555";
  app.add_option("--run-dir", options.learner.folder, "folder of the run, runs/NAME")->required();
  app.add_option("--config", options.learner.config,
                 "settings (deploy/*.textproto); default: those stored in the run's folder")
      ->check(CLI::ExistingFile);
  app.add_option("--set", options.learner.changes,
                 "PATH=VALUE overrides one setting; may be repeated")
      ->take_all();
  app.add_flag_callback(
      "--help-options",
      [] {
        std::cout << SettingsHelp();
        throw CLI::Success();
      },
      "every setting with its default, meaning and range");
  app.add_option("--initial-weights", options.learner.first_weights,
                 "what a new run starts from: a .checkpoint file with its optimizer, or\n" +
                     std::string(kModelHelp) + "; a run that has begun keeps its own");
  app.add_option("--demonstrations", options.learner.demonstrations,
                 "recorded games of the official environment, plain or gzip, as replay --export\n"
                 "writes them: a new run's first iteration learns what everybody did in all of\n"
                 "them, and then the games begin; a run that has begun keeps its own");
  app.add_option("--listen", options.learner.listen,
                 "tcp://*:PORT, tcp://127.0.0.1:PORT or ipc://PATH");
  app.add_option("--keys", options.learner.keys, "folder of CURVE keys (deploy/keys)");
  app.add_flag("--insecure", options.learner.insecure, "allow other machines without keys");
  app.add_option(
      "--http", options.http,
      "where to serve a dashboard, /status.json, /iterations.csv and /metrics (Prometheus):\n"
      "ADDRESS:PORT (port 0: any free one), off, or auto: 127.0.0.1:8265 or, where that is\n"
      "taken, any free port. Read-only and unauthenticated: whoever reaches it sees the run");
  app.add_flag("--check", options.check,
               "check the run's name, settings and demonstrations, write nothing, end");
  app.add_option("--log-level", options.log_level, "debug, info, warn or error");
}

int Run(Options& options) {
  std::signal(SIGINT, [](int) { stop_signal = 1; });
  std::signal(SIGTERM, [](int) { stop_signal = 1; });
  std::signal(SIGHUP, [](int) { stop_signal = 1; });
  std::signal(SIGPIPE, SIG_IGN);  // nobody watches the display any more
  try {
    AllowManyDescriptors();
    options.learner.http = DashboardServer(options.http);
    const LearnerSettings& learner = options.learner;
    const RunConfig config = CheckRun(learner.folder, learner.config, learner.changes);
    if (options.check) {
      CheckDemonstrations(learner.folder, learner.demonstrations, config.self_play.environment);
      return kDone;
    }
    const std::filesystem::path logs = options.learner.folder / "log";
    std::filesystem::create_directories(logs);
    const RunLock lock(options.learner.folder);  // before anything of another's is written
    log::Init((logs / "learner.log").string(), log::LevelFor(options.log_level),
              /*console=*/log::Level::kWarn);  // the display shows the rest
    Learner(options.learner).Run([] { return stop_signal != 0; });
    return kDone;
  } catch (const std::exception& error) {
    log::Error("learner failed", "reason", error.what());
    return kFailed;
  }
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  CLI::App app(
      "Powderkeg's learner: verifies and stores the games that actors send, trains on them and\n"
      "sends new weights. Started again on the same folder it goes on where it was.",
      "learner");
  powderkeg::Options options;
  powderkeg::AddOptions(app, options);
  if (const auto code = powderkeg::ReadCommandLine(app, argc, argv)) return *code;
  return powderkeg::Run(options);
}

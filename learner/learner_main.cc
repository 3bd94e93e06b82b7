// The learner: takes games in, trains, hands weights out, until the run's iterations are done.

#include <fcntl.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/durable_file.h"
#include "common/base/log.h"
#include "common/base/worker.h"
#include "common/config/config.h"
#include "common/http/http_server.h"
#include "common/pommerman/game_settings.h"
#include "common/wire/zmq_transport.h"
#include "learner/intake/session_server.h"
#include "learner/replay/store.h"
#include "learner/report/dashboard.h"
#include "learner/report/iteration_history.h"
#include "learner/report/iteration_table.h"
#include "learner/report/live_line.h"
#include "learner/report/run_view.h"
#include "learner/train/learner_loop.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;

// Small segments that are merged within an iteration too, that long ones do not fill the folder.
constexpr std::size_t kManySegments = 1000;

volatile std::sig_atomic_t stop_signal = 0;

struct Options {
  std::filesystem::path run_dir;
  std::string config;
  std::vector<std::string> changes;
  std::string listen = "tcp://127.0.0.1:5555";
  std::string keys;
  bool insecure = false;
  std::string http = "off";
  std::string log_level = "info";
};

// Where the dashboard is served if nobody says where.
const HttpAddress kUsualHttpAddress{.host = "127.0.0.1", .port = 8265};

// What --http says; nullopt: nothing is served.
std::optional<HttpServerSettings> HttpSettingsFor(const std::string& text) {
  if (text == "off") return std::nullopt;
  HttpServerSettings settings;
  settings.threads = 4;
  settings.max_waiting = 64;
  settings.max_request_bytes = 1024;
  settings.io_timeout = milliseconds(5000);
  settings.any_port_if_taken = text == "auto";
  const auto address = text == "auto" ? kUsualHttpAddress : ParseHttpAddress(text);
  if (!address) {
    throw Error(StrCat("--http is '", text,
                       "', expected ADDRESS:PORT with a port from 0 to 65535, ", "auto or off"));
  }
  settings.address = *address;
  return settings;
}

// Only one learner at a time may own a run. Held until the process ends.
class RunLock {
 public:
  explicit RunLock(const std::filesystem::path& folder) {
    const std::string path = (folder / "learner.lock").string();
    file_ = open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
    if (file_ < 0) throw Error(StrCat("cannot create ", path, ": ", std::strerror(errno)));
    if (flock(file_, LOCK_EX | LOCK_NB) == 0) return;
    if (errno == EWOULDBLOCK) throw Error(StrCat(folder.string(), " is in use by another learner"));
    throw Error(StrCat("cannot lock ", path, ": ", std::strerror(errno)));
  }
  ~RunLock() { close(file_); }
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;

 private:
  int file_;
};

void StoreText(const std::filesystem::path& path, const std::string& text) {
  WriteFileDurably(path, BytesOf(text));
}

// The folder's name as far as it can be part of a name on the wire.
std::string NameOf(const std::filesystem::path& folder) {
  constexpr std::size_t kLongest = 40;
  std::string name = std::filesystem::absolute(folder / ".").parent_path().filename().string();
  std::ranges::replace_if(
      name, [](unsigned char c) { return c <= ' ' || c > '~'; }, '_');
  return name.substr(0, kLongest);
}

// A random name of the run, made at its first start: actors must not mix runs up.
std::string RunIdOf(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "run_id";
  std::string id;
  if (std::ifstream(path) >> id) return id;
  std::random_device device;
  char text[33];
  std::snprintf(text, sizeof text, "%08x%08x", device(), device());
  id = NameOf(folder) + "-" + text;
  StoreText(path, id + '\n');
  return id;
}

std::filesystem::path StoredConfig(const Options& options) {
  return options.run_dir / "config.textproto";
}

// The settings of a run are kept with it; a later start may change them.
RunConfig ConfigOf(const Options& options) {
  std::string source = options.config;
  if (source.empty() && std::filesystem::exists(StoredConfig(options))) {
    source = StoredConfig(options).string();
  }
  return LoadConfig(source, options.changes);
}

// What is shown while it runs: a live line on a terminal, a plain line now and then elsewhere, and
// the table of iterations.
class Display {
 public:
  Display() : terminal_(isatty(STDOUT_FILENO) != 0) {}

  void ShowStatus(const LiveStatus& status) {
    const auto now = LiveLine::Clock::now();
    const std::string line = live_.Next(status, now, Width());
    if (terminal_) {
      std::cout << "\r\033[K" << line << std::flush;
    } else if (now - last_plain_ >= std::chrono::seconds(15)) {
      std::cout << line << std::endl;
      last_plain_ = now;
    }
  }

  static void ShowLine(const std::string& line) { std::cout << line << std::endl; }

  void ShowIteration(const IterationReport& report) {
    Clear();
    if (lines_++ % 20 == 0) std::cout << FitTable(TableHeader(), Width()) << '\n';
    std::cout << FitTable(TableLine(report), Width()) << std::endl;
  }

  void Clear() {
    if (terminal_) std::cout << "\r\033[K" << std::flush;
  }

 private:
  // Characters that fit into a line of the terminal, which may change, without a wrap.
  [[nodiscard]] std::size_t Width() const {
    winsize size{};
    if (!terminal_ || ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col < 2) {
      return std::string::npos;
    }
    return size.ws_col - std::size_t{1};
  }

  const bool terminal_;
  LiveLine live_;
  LiveLine::Clock::time_point last_plain_;
  int lines_ = 0;
};

LiveStatus StatusOf(const LearnerLoop::Progress& progress, const IntakeStatistics& intake,
                    int iterations) {
  LiveStatus status;
  status.iterations_done = progress.iteration;
  status.iterations = iterations;
  status.decisions = progress.games.decisions_in_prefix;
  status.decisions_wanted = progress.decisions_wanted;
  status.decisions_beyond = progress.games.decisions - progress.games.decisions_in_prefix;
  status.straggler = progress.games.straggler;
  status.samples = progress.training.samples_done;
  status.samples_wanted = progress.training.samples;
  status.actors = intake.actors.size();
  status.totals.games = intake.games;
  status.totals.decisions = intake.decisions;
  for (const ActorStatistics& actor : intake.actors) {
    status.totals.evaluations += actor.heartbeat.evaluations;
    status.totals.batches += actor.heartbeat.batches;
  }
  return status;
}

// Everything between a run's folder and the end of the process.
class Learner {
 public:
  Learner(const Options& options, const std::optional<HttpServerSettings>& http)
      : name_(NameOf(options.run_dir)),
        lock_(options.run_dir),
        config_(ConfigOf(options)),
        store_(options.run_dir / "replay"),
        loop_(LoopSettings(options), LoopHooks()),
        history_(options.run_dir / "iterations.csv") {
    const std::vector<std::uint64_t> known = LoadGames();
    log::Info("run opened", "folder", options.run_dir.string(), "games", known.size(),
              "iterations_done", loop_.progress().iteration);
    ServeActors(options, known);
    if (http) ServeHttp(*http);
    StoreText(StoredConfig(options), ToText(config_));  // nothing has turned out wrong
    Display::ShowLine(StrCat(options.run_dir.string(), ": ", loop_.progress().iteration, " of ",
                             config_.training.iterations, " iterations done, ", known.size(),
                             " games stored"));
    Display::ShowLine(StrCat("actors connect to ", server_->endpoint()));
  }

  // Returns when every iteration is done or a signal came. Throws Error.
  void Run() {
    Worker trainer("trainer", [this](const std::stop_token& stop) { loop_.Run(stop); });
    while (stop_signal == 0 && !trainer.finished() && !server_->failed()) {
      display_.ShowStatus(View().status);
      std::this_thread::sleep_for(milliseconds(500));
    }
    display_.Clear();
    // A trainer that failed has finished too: actors that then left would not come back.
    const bool complete = loop_.progress().iteration >= config_.training.iterations;
    trainer.RequestStop();
    server_->Stop({complete ? "the run is complete" : "the learner stops", complete});
    trainer.Join();
    const int done = loop_.progress().iteration;
    log::Info(complete ? "run complete" : "stopped", "iterations_done", done);
    Display::ShowLine(StrCat(complete ? "run complete" : "stopped", ": ", done, " of ",
                             config_.training.iterations, " iterations done"));
  }

 private:
  LearnerLoopSettings LoopSettings(const Options& options) const {
    LearnerLoopSettings settings;
    RunConfig tied = config_;
    TieOutcomesToSearch(tied);
    settings.training = tied.training;
    settings.game = GameOf(config_.self_play);
    settings.folder = options.run_dir;
    settings.seed = config_.self_play.seed;
    return settings;
  }

  LearnerLoopHooks LoopHooks() {
    return {.publish = [this](const Snapshot& snapshot) { server_->Publish(snapshot); },
            .iteration_done =
                [this](const IterationReport& report) {
                  history_.Append(report);
                  display_.ShowIteration(report);
                  merge_wanted_ = true;
                }};
  }

  // The tickets of the games stored so far; those that are still needed go to the loop.
  std::vector<std::uint64_t> LoadGames() {
    std::vector<std::uint64_t> known;
    store_.Load(
        [&](std::uint64_t ticket) {
          known.push_back(ticket);
          return loop_.Wants(ticket);
        },
        [&](GameRecord&& game) { loop_.Add(std::move(game)); });
    return known;
  }

  void ServeActors(const Options& options, std::span<const std::uint64_t> known) {
    std::optional<std::filesystem::path> keys;
    if (!options.keys.empty()) keys = options.keys;
    SessionServerSettings settings;
    settings.run_id = RunIdOf(options.run_dir);
    settings.self_play = config_.self_play;
    settings.games_wanted = [this] { return loop_.GamesWanted(); };
    server_ = std::make_unique<SessionServer>(
        settings, ListenZmq({options.listen, keys, options.insecure}),
        [this](std::vector<GameRecord> games) { Append(std::move(games)); }, known);
    log::Info("listening", "endpoint", server_->endpoint(), "keys", keys ? "yes" : "no");
  }

  // On the store thread, which makes all HDF5 calls.
  void Append(std::vector<GameRecord> games) {
    store_.Append(games);
    if (merge_wanted_.exchange(false) || store_.small_segment_count() >= kManySegments) {
      store_.Merge();
    }
    for (GameRecord& game : games) loop_.Add(std::move(game));
  }

  // By any thread.
  [[nodiscard]] RunView View() const {
    RunView view{.run = name_, .started_unix_s = started_};
    view.intake = server_->statistics();
    view.status = StatusOf(loop_.progress(), view.intake, config_.training.iterations);
    view.last_iteration = history_.last();
    return view;
  }

  void ServeHttp(const HttpServerSettings& settings) {
    http_.emplace(DashboardRoutes([this] { return View(); }, history_), settings);
    const HttpAddress& address = http_->address();
    const int asked = settings.address.port;
    const bool taken = asked != 0 && address.port != asked;
    log::Info("serving the dashboard", "url", address.url());
    Display::ShowLine(
        StrCat("dashboard: ", address.url(), taken ? StrCat(" (port ", asked, " is taken)") : ""));
  }

  const std::string name_;
  const std::time_t started_ = std::time(nullptr);
  RunLock lock_;
  RunConfig config_;
  Display display_;
  std::atomic<bool> merge_wanted_ = false;
  ReplayStore store_;
  LearnerLoop loop_;
  IterationHistory history_;
  std::unique_ptr<SessionServer> server_;  // its threads use what stands above
  std::optional<HttpServer> http_;         // and so do its
};

// Every peer takes a file, and without one left nothing could be stored.
void AllowManyFiles() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

int Main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "Powderkeg's learner: verifies and stores the games that actors send, trains on them and\n"
      "sends new weights. Started again on the same folder it goes on where it was."};
  app.add_option("--run-dir", options.run_dir, "folder of the run, runs/NAME")->required();
  app.add_option("--config", options.config,
                 "settings (deploy/*.textproto); default: those stored in the run's folder")
      ->check(CLI::ExistingFile);
  app.add_option("--set", options.changes, "PATH=VALUE overrides one setting; may be repeated")
      ->take_all();
  app.add_flag_callback(
      "--help-options",
      [] {
        std::cout << SettingsHelp();
        throw CLI::Success();
      },
      "every setting with its default, meaning and range");
  app.add_option("--listen", options.listen, "tcp://*:PORT, tcp://127.0.0.1:PORT or ipc://PATH")
      ->capture_default_str();
  app.add_option("--keys", options.keys, "folder of CURVE keys (deploy/keys)");
  app.add_flag("--insecure", options.insecure, "allow other machines without keys");
  app.add_option(
         "--http", options.http,
         "where to serve a dashboard, /status.json, /iterations.csv and /metrics (Prometheus):\n"
         "ADDRESS:PORT (port 0: any free one), off, or auto: 127.0.0.1:8265 or, where that is\n"
         "taken, any free port. Read-only and unauthenticated: whoever reaches it sees the run")
      ->capture_default_str();
  app.add_option("--log-level", options.log_level, "debug, info, warn or error")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);

  AllowManyFiles();
  std::signal(SIGINT, [](int) { stop_signal = 1; });
  std::signal(SIGTERM, [](int) { stop_signal = 1; });
  std::signal(SIGHUP, [](int) { stop_signal = 1; });
  try {
    const auto http = HttpSettingsFor(options.http);
    std::filesystem::create_directories(options.run_dir / "log");
    log::Init((options.run_dir / "log" / "learner.log").string(), log::LevelFor(options.log_level),
              /*console=*/log::Level::kWarn);  // the display shows the rest
    Learner(options, http).Run();
    return 0;
  } catch (const Error& error) {
    log::Error("learner failed", "reason", error.what());
    return 1;
  } catch (const std::filesystem::filesystem_error& error) {
    log::Error("learner failed", "reason", error.what());
    return 1;
  }
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) { return powderkeg::Main(argc, argv); }

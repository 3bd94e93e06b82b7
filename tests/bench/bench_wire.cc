#include "tests/bench/bench_wire.h"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "actors/selfplay/outbox.h"
#include "actors/selfplay/session_client.h"
#include "actors/selfplay/ticket_book.h"
#include "common/base/check.h"
#include "common/base/log.h"
#include "common/config/config.h"
#include "common/wire/codec.h"
#include "common/wire/zmq_transport.h"
#include "learner/intake/session_server.h"
#include "learner/replay/store.h"
#include "tests/learner/record_support.h"
#include "tests/wire/played_tickets.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kGames = 8000;
constexpr int kActors = 2;
constexpr std::uint32_t kLoops = 4;    // of an actor
constexpr std::uint32_t kVersion = 7;  // of the weights at the start of every game
constexpr auto kLimit = std::chrono::seconds(60);

struct Prepared {
  std::vector<SealedGame> games;  // by ticket
  std::size_t decisions = 0;
  std::size_t bytes = 0;
};

Prepared Prepare(const SelfPlayConfig& config) {
  Prepared prepared;
  for (std::uint64_t ticket = 0; ticket < kGames; ++ticket) {
    const GameRecord record = PlayTicket(config, ticket, kVersion);
    prepared.games.push_back(Seal(record, SettingsDigest(config)));
    prepared.decisions += DecisionCount(record);
    prepared.bytes += prepared.games.back().record.size();
  }
  return prepared;
}

// A real actor but for the playing: its games are there already.
void ActAsActor(const std::string& endpoint, const std::filesystem::path& spool,
                const Prepared& prepared) {
  Outbox outbox(spool, std::size_t{64} << 20);
  TicketBook tickets;
  SessionClientSettings settings;
  settings.name = spool.filename();
  settings.incarnation = static_cast<std::uint64_t>(getpid());
  settings.loops = kLoops;
  SessionClient client(
      settings, [&] { return ConnectZmq(endpoint, std::nullopt); }, outbox, tickets,
      [] { return Heartbeat{}; });
  while (!client.ended()) {
    tickets.WaitForTicket(milliseconds(20));
    while (const auto grant = tickets.Take()) {
      if (grant->ticket < kGames) outbox.Add(prepared.games[grant->ticket]);
    }
    client.GameAdded();
  }
  client.Leave(milliseconds(0));
}

// A process that acts as an actor; killed with its owner.
class ActorProcess {
 public:
  ActorProcess(const std::string& endpoint, const std::filesystem::path& spool,
               const Prepared& prepared)
      : process_(fork()) {
    if (process_ < 0) throw Error("cannot start another process");
    if (process_ > 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    try {
      ActAsActor(endpoint, spool, prepared);
    } catch (const Error& error) {
      log::Error("actor failed", "reason", error.what());
      _exit(1);
    }
    _exit(0);
  }
  ~ActorProcess() {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  ActorProcess(const ActorProcess&) = delete;
  ActorProcess& operator=(const ActorProcess&) = delete;

 private:
  const pid_t process_;
};

// Seconds of processor time of this process's threads.
double ProcessorSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// In memory: the actors' disks are not what is measured.
std::filesystem::path SpoolParent() {
  const std::filesystem::path memory = "/dev/shm";
  return std::filesystem::exists(memory) ? memory : std::filesystem::temp_directory_path();
}

// Takes every game once; the learner's processor time for it.
double MeasureIntake(const SelfPlayConfig& config, const Prepared& prepared,
                     const AppendGames& append) {
  const TemporaryFolder folder(SpoolParent());
  const std::string endpoint = StrCat("ipc://", folder.path().string(), "/learner.sock");
  // Before there are threads: a fork copies only its own.
  std::vector<std::unique_ptr<ActorProcess>> actors;
  for (int i = 0; i < kActors; ++i) {
    const auto spool = folder.path() / StrCat("actor-", i);
    actors.push_back(std::make_unique<ActorProcess>(endpoint, spool, prepared));
  }
  const double start_s = ProcessorSeconds();
  const Clock::time_point deadline = Clock::now() + kLimit;
  std::atomic<std::size_t> stored = 0;
  SessionServerSettings settings;
  settings.run_id = "bench";
  settings.newest_version = kVersion + 1;
  settings.self_play = config;
  SessionServer server(settings, ListenZmq({.endpoint = endpoint}),
                       [&](const std::vector<GameRecord>& games, std::vector<Lessons> lessons) {
                         append(games, std::move(lessons));
                         stored += games.size();
                       });
  while (stored < kGames && !server.failed() && Clock::now() < deadline) {
    std::this_thread::sleep_for(milliseconds(5));
  }
  server.Stop({.reason = "measured", .run_complete = true});
  if (stored < kGames) throw Error(StrCat("took ", stored, " of ", kGames, " games in time"));
  return ProcessorSeconds() - start_s;
}

}  // namespace

std::vector<BenchFigure> BenchWire() {
  log::Init(/*file=*/"", log::Level::kWarn);
  SelfPlayConfig config;
  config.games_in_flight = 128;
  const Prepared prepared = Prepare(config);
  const auto decisions = static_cast<double>(prepared.decisions);
  SelfPlayConfig four_learn = config;
  four_learn.players = {{.name = "me", .teaches = PlayerSpec::Teaches::kSearch}};
  four_learn.lineups = {{.seats = {"me", "me", "me", "me"}}};
  const Prepared four = Prepare(four_learn);
  const double memory_s =
      MeasureIntake(config, prepared, [](const auto& /*games*/, const auto& /*lessons*/) {});
  const TemporaryFolder folder;
  ReplayStore store(folder.path());
  const double hdf5_s = MeasureIntake(
      config, prepared, [&](const auto& games, const auto& /*lessons*/) { store.Append(games); });
  return {{"bytes_per_decision", static_cast<double>(prepared.bytes) / decisions, "bytes"},
          {"bytes_per_decision_of_four",
           static_cast<double>(four.bytes) / static_cast<double>(four.decisions), "bytes"},
          {"ingest_hdf5", decisions / hdf5_s, "decisions/s"},
          {"ingest_per_core", decisions / memory_s, "decisions/s"}};
}

}  // namespace powderkeg

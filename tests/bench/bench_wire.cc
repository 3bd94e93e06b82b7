#include "tests/bench/bench_wire.h"

#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <ctime>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/wire/codec.h"
#include "common/wire/zmq_transport.h"
#include "learner/intake/session_server.h"
#include "tests/wire/played_tickets.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kGames = 4000;

struct Prepared {
  std::vector<SealedGame> games;  // by ticket
  std::size_t decisions = 0;
  std::size_t bytes = 0;
};

Prepared Prepare(const SelfPlayConfig& config) {
  Prepared prepared;
  for (std::uint64_t ticket = 0; ticket < kGames; ++ticket) {
    const GameRecord record = PlayTicket(config, ticket);
    prepared.games.push_back(Seal(record, {}));
    prepared.decisions += record.decisions.size();
    prepared.bytes += prepared.games.back().record.size();
  }
  return prepared;
}

// Sends the games of the tickets it is granted until all are acknowledged.
void ActAsActor(ClientChannel& channel, const Prepared& prepared) {
  const Waker waker;
  Hello hello;
  hello.name = "bench";
  hello.loops = 8;
  while (!channel.Send(Encode(hello))) (void)channel.Receive(milliseconds(1), waker);
  std::size_t acknowledged = 0;
  while (acknowledged < kGames) {
    const auto bytes = channel.Receive(milliseconds(1000), waker);
    if (!bytes) continue;
    const auto decoded = Decode(*bytes);
    const auto* message = std::get_if<WireMessage>(&decoded);
    const auto* ack = message == nullptr ? nullptr : std::get_if<Ack>(message);
    if (ack == nullptr) continue;
    CHECK(ack->rejected.empty());
    acknowledged += ack->durable.size();
    Games games;
    for (const std::uint64_t ticket : ack->tickets) {
      if (ticket < kGames) games.games.push_back(prepared.games[ticket]);
      if (games.games.size() < 64) continue;
      CHECK(channel.Send(Encode(games)));
      games.games.clear();
    }
    if (!games.games.empty()) CHECK(channel.Send(Encode(games)));
  }
}

}  // namespace

std::vector<BenchFigure> BenchWire() {
  SessionServerSettings settings;
  settings.run_id = "bench";
  settings.self_play.games_in_flight = 256;
  settings.commit_interval = milliseconds(20);
  const Prepared prepared = Prepare(settings.self_play);
  const std::string endpoint = "ipc:///tmp/powderkeg-bench-" + std::to_string(getpid());
  std::size_t stored = 0;
  SessionServer server(settings, ListenZmq({.endpoint = endpoint}),
                       [&](const std::vector<GameRecord>& games) { stored += games.size(); });
  const auto channel = ConnectZmq(endpoint, std::nullopt);
  const Clock::time_point start = Clock::now();
  const std::clock_t processor_start = std::clock();
  ActAsActor(*channel, prepared);
  const double processor_s = static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC;
  const double wall_s = std::chrono::duration<double>(Clock::now() - start).count();
  server.Stop({.reason = "measured", .run_complete = true});
  CHECK(stored == kGames, stored);
  const auto decisions = static_cast<double>(prepared.decisions);
  return {{"bytes_per_decision", static_cast<double>(prepared.bytes) / decisions, "bytes"},
          {"ingest", decisions / wall_s, "decisions/s"},
          {"ingest_per_core", decisions / processor_s, "decisions/s"}};
}

}  // namespace powderkeg

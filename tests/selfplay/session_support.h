#pragma once

// A learner and actors for tests of the session.

#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "actors/selfplay/outbox.h"
#include "actors/selfplay/session_client.h"
#include "actors/selfplay/ticket_book.h"
#include "common/base/check.h"
#include "common/model/weights_snapshot.h"
#include "learner/intake/session_server.h"
#include "tests/wire/played_tickets.h"

namespace powderkeg {

// Looks again and again until the condition holds; false after ten seconds.
inline bool Eventually(const std::function<bool()>& condition) {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  constexpr auto kPatience = std::chrono::seconds(40);
#else
  constexpr auto kPatience = std::chrono::seconds(10);
#endif
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() >= deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

inline SessionServerSettings QuickSettings() {
  SessionServerSettings settings;
  settings.run_id = "test";
  settings.self_play = QuickConfig();
  settings.heartbeat = std::chrono::milliseconds(30);
  settings.dead_after = std::chrono::milliseconds(400);
  settings.commit_interval = std::chrono::milliseconds(5);
  return settings;
}

inline Snapshot SomeWeights(std::uint32_t version) {
  auto snapshot = std::make_shared<WeightsSnapshot>(InitialWeights(SmallNetwork(), Rng(version)));
  snapshot->version = version;
  return snapshot;
}

class TemporarySpool {
 public:
  TemporarySpool() {
    std::string name = (std::filesystem::temp_directory_path() / "pk-spool-XXXXXX").string();
    CHECK(mkdtemp(name.data()) != nullptr);
    path_ = name;
  }
  ~TemporarySpool() { std::filesystem::remove_all(path_); }
  TemporarySpool(const TemporarySpool&) = delete;
  TemporarySpool& operator=(const TemporarySpool&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// A server whose store is a vector.
class TestLearner {
 public:
  explicit TestLearner(std::unique_ptr<ServerChannel> channel,
                       SessionServerSettings settings = QuickSettings(),
                       const std::vector<std::uint64_t>& known = {})
      : server(std::make_unique<SessionServer>(
            std::move(settings), std::move(channel),
            [this](const auto& games, const auto& /*lessons*/) { Append(games); }, known)) {}
  ~TestLearner() { Release(); }

  // Appends wait from now on, until Release.
  void Hold() { SetHeld(true); }
  void Release() { SetHeld(false); }
  void FailWith(const std::string& reason) {
    const std::lock_guard lock(mutex_);
    failure_ = reason;
  }

  [[nodiscard]] std::vector<GameRecord> games() const {
    const std::lock_guard lock(mutex_);
    return games_;
  }
  [[nodiscard]] std::vector<std::uint64_t> Tickets() const {
    std::vector<std::uint64_t> tickets;
    for (const GameRecord& game : games()) tickets.push_back(game.ticket);
    return tickets;
  }

 private:
  void SetHeld(bool held) {
    {
      const std::lock_guard lock(mutex_);
      held_ = held;
    }
    released_.notify_all();
  }
  void Append(const std::vector<GameRecord>& games) {
    std::unique_lock lock(mutex_);
    released_.wait(lock, [&] { return !held_; });
    if (!failure_.empty()) throw Error(failure_);
    games_.insert(games_.end(), games.begin(), games.end());
  }

  mutable std::mutex mutex_;
  std::condition_variable released_;
  bool held_ = false;
  std::string failure_;
  std::vector<GameRecord> games_;

 public:
  std::unique_ptr<SessionServer> server;
};

// A client that plays by PlayTicket.
class TestActor {
 public:
  explicit TestActor(Connect connect, const std::string& name = "actor",
                     const std::filesystem::path& spool = {}, const std::string& run_id = "",
                     std::chrono::milliseconds give_up = {})
      : outbox(spool.empty() ? own_spool_.path() : spool, std::size_t{1} << 20) {
    static std::atomic<std::uint64_t> incarnations = 0;
    SessionClientSettings settings;
    settings.run_id = run_id;
    settings.build = "test";
    settings.name = name;
    settings.incarnation = ++incarnations;
    settings.dead_after = std::chrono::milliseconds(400);
    settings.first_backoff = std::chrono::milliseconds(5);
    settings.last_backoff = std::chrono::milliseconds(50);
    settings.give_up = give_up;
    client = std::make_unique<SessionClient>(settings, std::move(connect), outbox, tickets,
                                             [] { return Heartbeat{.evaluations = 42}; });
  }

  // Plays the next ticket and sends the game; one must wait.
  std::uint64_t PlayOne() {
    const std::uint64_t ticket = tickets.Take().value().ticket;
    Send(SealedTicket(QuickConfig(), ticket));
    return ticket;
  }
  void Send(const SealedGame& game) {
    outbox.Add(game);
    client->GameAdded();
  }

 private:
  TemporarySpool own_spool_;

 public:
  Outbox outbox;
  TicketBook tickets;
  std::unique_ptr<SessionClient> client;
};

}  // namespace powderkeg

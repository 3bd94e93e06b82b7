#pragma once

// The actor's side of the session (proto/wire.proto).

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>

#include "actors/selfplay/connection.h"
#include "actors/selfplay/outbox.h"
#include "actors/selfplay/ticket_book.h"
#include "actors/selfplay/weights_fetcher.h"
#include "common/base/rng.h"
#include "common/base/worker.h"
#include "common/model/weights_snapshot.h"
#include "common/wire/messages.h"
#include "common/wire/transport.h"

namespace powderkeg {

struct SessionClientSettings {
  std::string run_id;  // empty: whatever run the learner has
  std::string build;
  std::string name;
  std::uint64_t incarnation = 0;  // random per start; also seeds the jitter
  std::uint32_t loops = 1;
  // Until Welcome tells the learner's own figures.
  std::chrono::milliseconds dead_after{5000};
  // Wait before connecting again: doubles from first to last, less up to half of it at random.
  std::chrono::milliseconds first_backoff{200};
  std::chrono::milliseconds last_backoff{10'000};
  // Time without a session after which it ends; 0: it looks for the learner for ever.
  std::chrono::milliseconds give_up{0};
  std::size_t weights_kept = 8;  // versions in memory besides the newest
};

// Owns the io thread and its connection, from construction to Leave. Reconnects until it gives up;
// after a reconnect every game in the outbox is sent again. Public methods are thread-safe except
// Leave.
class SessionClient {
 public:
  // `outbox`, `tickets` must outlive it. `statistics` is called on the io thread.
  SessionClient(SessionClientSettings settings, Connect connect, Outbox& outbox,
                TicketBook& tickets, std::function<Heartbeat()> statistics);
  // Leaves at once if nobody did; an Error is logged.
  ~SessionClient();
  SessionClient(const SessionClient&) = delete;
  SessionClient& operator=(const SessionClient&) = delete;

  // A game was added to the outbox.
  void GameAdded() { waker_.Notify(); }

  // The newest Welcome; null before the first. Changes when the learner returns with other
  // settings.
  [[nodiscard]] std::shared_ptr<const Welcome> welcome() const;
  // The newest weights, whole and checked; null before the first.
  [[nodiscard]] Snapshot weights() const { return weights_.newest(); }
  // Whether the learner has said that there are no weights yet: play by the uniform evaluator.
  [[nodiscard]] bool no_weights_yet() const { return weights_.none_yet(); }
  // The weights of any version that the learner has. Does not wait: what is neither here nor said
  // to be gone comes later.
  [[nodiscard]] WantedWeights Want(std::uint32_t version) { return weights_.Want(version); }
  // Waits until any of the above or ended() changed since the call of `version`, or time is up.
  [[nodiscard]] std::uint64_t version() const;
  void WaitForChange(std::uint64_t version, std::chrono::milliseconds timeout) const;

  // Whether the session is over: the run is complete, the actor was refused for good (Leave
  // rethrows that), or it gave up.
  [[nodiscard]] bool ended() const { return ended_; }
  [[nodiscard]] bool gave_up() const { return gave_up_; }

  // Waits until the outbox is acknowledged, for `patience` at most, says Goodbye and joins.
  // Rethrows the Error that ended the session.
  void Leave(std::chrono::milliseconds patience);

 private:
  using Clock = std::chrono::steady_clock;

  void Run(const std::stop_token& stop);
  void Serve(Connection& connection);
  void Publish(const Welcome& welcome);
  [[nodiscard]] Hello Greeting() const;
  [[nodiscard]] bool IsTooLong(Clock::duration absence) const;
  void Pause(std::chrono::milliseconds backoff);
  void Changed();
  [[nodiscard]] std::optional<Clock::time_point> deadline() const;

  const SessionClientSettings settings_;
  const Connect connect_;
  Outbox& outbox_;
  TicketBook& tickets_;
  const std::function<Heartbeat()> statistics_;
  const Waker waker_;
  WeightsFetcher weights_;
  Rng rng_;  // the io thread's

  mutable std::mutex mutex_;  // guards these
  mutable std::condition_variable changed_;
  std::shared_ptr<const Welcome> welcome_;
  std::uint64_t version_ = 0;
  std::optional<Clock::time_point> deadline_;  // set when leaving

  std::atomic<bool> gave_up_ = false;
  std::atomic<bool> ended_ = false;
  std::unique_ptr<Worker> io_;
};

}  // namespace powderkeg

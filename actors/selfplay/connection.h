#pragma once

// One connection of an actor to the learner, from Hello to its end (proto/wire.proto).

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "actors/selfplay/outbox.h"
#include "actors/selfplay/ticket_book.h"
#include "actors/selfplay/weights_fetcher.h"
#include "common/wire/messages.h"
#include "common/wire/transport.h"

namespace powderkeg {

// What an actor brings to each of its connections. All must outlive them.
struct ConnectionParts {
  Outbox& outbox;
  TicketBook& tickets;
  WeightsFetcher& weights;
  std::function<Heartbeat()> statistics;
};

// One thread.
class Connection {
 public:
  using Clock = std::chrono::steady_clock;
  enum class End : std::uint8_t { kRetry, kOver };

  // Says `hello` with the tickets that are in play once the channel takes it. Until Welcome tells
  // the learner's own figure a silence of `dead_after` ends the connection.
  Connection(std::unique_ptr<ClientChannel> channel, ConnectionParts parts, Hello hello,
             std::chrono::milliseconds dead_after);

  // Sends what is due and handles what comes, until there was nothing for a while, the waker was
  // notified or the connection has ended. Leaves when the outbox is empty or at `leave_by`, if
  // there is one. Throws Error if the learner refused this actor for good.
  void Round(const Waker& waker, std::optional<Clock::time_point> leave_by);

  // How it ended, if it has.
  [[nodiscard]] std::optional<End> end() const { return end_; }
  // nullopt: it has not come.
  [[nodiscard]] const std::optional<Welcome>& welcome() const { return welcome_; }
  [[nodiscard]] Clock::time_point last_heard() const { return last_heard_; }

 private:
  void Greet();
  void SendGames();
  void SendDue(Clock::time_point now);
  void CheckSilence(Clock::time_point now);
  void CheckLeaving(Clock::time_point now, std::optional<Clock::time_point> leave_by);
  void Handle(const std::string& bytes);
  void Handle(const Welcome& welcome);
  void Handle(const Refused& refused);
  void Handle(const Ack& ack);
  void Handle(const Goodbye& goodbye);
  [[nodiscard]] std::chrono::milliseconds heartbeat() const;

  const std::unique_ptr<ClientChannel> channel_;
  const ConnectionParts parts_;
  Hello hello_;
  std::chrono::milliseconds dead_after_;
  bool greeted_ = false;  // Hello was taken by the channel
  std::optional<Welcome> welcome_;
  std::uint64_t cursor_ = 0;  // in the outbox: what was sent
  Clock::time_point last_heard_ = Clock::now();
  Clock::time_point last_heartbeat_;
  std::optional<End> end_;
};

}  // namespace powderkeg

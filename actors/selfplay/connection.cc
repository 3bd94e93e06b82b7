#include "actors/selfplay/connection.h"

#include <type_traits>
#include <utility>
#include <variant>

#include "common/base/check.h"
#include "common/base/log.h"
#include "common/wire/codec.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstHeartbeat{1000};   // until Welcome tells the learner's own figure
constexpr milliseconds kNotConnectedPause{20};  // between two attempts to say Hello
constexpr std::size_t kBatchBytes = std::size_t{256} << 10;

template <typename Message>
constexpr bool kOnlyActorsSay = std::is_same_v<Message, Hello> || std::is_same_v<Message, Games> ||
                                std::is_same_v<Message, WeightsRequest>;
template <typename Message>
constexpr bool kAboutWeights =
    std::is_same_v<Message, WeightsOffer> || std::is_same_v<Message, WeightsChunk> ||
    std::is_same_v<Message, WeightsReceipt>;

}  // namespace

Connection::Connection(std::unique_ptr<ClientChannel> channel, ConnectionParts parts, Hello hello,
                       milliseconds dead_after)
    : channel_(std::move(channel)),
      parts_(std::move(parts)),
      hello_(std::move(hello)),
      dead_after_(dead_after) {
  parts_.weights.StartAnew();
}

milliseconds Connection::heartbeat() const {
  return welcome_ ? welcome_->heartbeat : kFirstHeartbeat;
}

void Connection::Round(const Waker& waker, std::optional<Clock::time_point> leave_by) {
  if (!greeted_) Greet();
  const Clock::time_point now = Clock::now();
  if (welcome_) SendDue(now);
  CheckLeaving(now, leave_by);
  CheckSilence(now);
  if (end_) return;
  auto bytes = channel_->Receive(greeted_ ? heartbeat() / 4 : kNotConnectedPause, waker);
  for (; bytes && !end_; bytes = channel_->Receive({}, waker)) {
    last_heard_ = Clock::now();
    Handle(*bytes);
  }
}

// Tickets that only wait are not claimed: meanwhile they may have become others', and the learner
// grants what is open anew. Played all the same, they would be played twice, and before those that
// everybody waits for.
void Connection::Greet() {
  hello_.tickets = parts_.tickets.Started();
  greeted_ = channel_->Send(Encode(hello_));
  if (greeted_) parts_.tickets.DropWaiting();  // until then they can be played
}

void Connection::SendDue(Clock::time_point now) {
  SendGames();
  if (now - last_heartbeat_ >= heartbeat()) {
    last_heartbeat_ = now;
    channel_->Send(Encode(parts_.statistics()));
  }
  if (const auto request = parts_.weights.NextRequest(now)) channel_->Send(Encode(*request));
}

void Connection::SendGames() {
  for (;;) {
    std::uint64_t cursor = cursor_;
    Games games{.games = parts_.outbox.Batch(cursor, kBatchBytes)};
    if (games.games.empty() || !channel_->Send(Encode(games))) return;
    cursor_ = cursor;
  }
}

void Connection::CheckSilence(Clock::time_point now) {
  if (now - last_heard_ < dead_after_) {
    const auto asked_at = parts_.weights.asked_at();
    if (!asked_at || now - *asked_at < dead_after_) return;
    log::Warn("the learner sends no weights, trying again", "after_ms", dead_after_.count());
  } else if (greeted_) {
    log::Warn("the learner is silent, trying again", "after_ms", dead_after_.count());
  } else {
    log::Warn("cannot reach the learner, trying again", "reason", channel_->Trouble());
  }
  end_ = End::kRetry;
}

void Connection::CheckLeaving(Clock::time_point now, std::optional<Clock::time_point> leave_by) {
  const std::size_t games = parts_.outbox.size();
  if (!leave_by || (games > 0 && now < *leave_by)) return;
  if (games > 0) log::Warn("leaving with games that are not acknowledged", "games", games);
  channel_->Send(Encode(Goodbye{.reason = "the actor ends"}));
  end_ = End::kOver;
}

void Connection::Handle(const std::string& bytes) {
  Decoded<WireMessage> decoded = Decode(bytes);
  if (const auto* malformed = std::get_if<Malformed>(&decoded)) {
    log::Warn("cannot read the learner", "reason", malformed->reason);
    end_ = End::kRetry;
    return;
  }
  std::visit(
      [&](const auto& message) {
        using Kind = std::decay_t<decltype(message)>;
        if constexpr (kOnlyActorsSay<Kind>) {
          log::Warn("the learner says what only actors say");
          end_ = End::kRetry;
        } else if constexpr (kAboutWeights<Kind>) {
          parts_.weights.Handle(message);
        } else if constexpr (!std::is_same_v<Kind, Heartbeat>) {
          Handle(message);
        }
      },
      std::get<WireMessage>(decoded));
}

void Connection::Handle(const Welcome& welcome) {
  log::Info("connected to the learner", "run", welcome.run_id);
  if (const auto aside = parts_.outbox.ServeRun(welcome.run_id); !aside.empty()) {
    for (const std::uint64_t ticket : aside) parts_.tickets.Settle(ticket);
    end_ = End::kRetry;  // Hello has claimed them: the learner would wait for them
    return;
  }
  parts_.weights.ServeRun(welcome.run_id);
  welcome_ = welcome;
  dead_after_ = welcome.dead_after;
}

void Connection::Handle(const Refused& refused) {
  if (!refused.retry) throw Error(StrCat("the learner refused this actor: ", refused.reason));
  log::Warn("the learner refused, trying again", "reason", refused.reason);
  end_ = End::kRetry;
}

void Connection::Handle(const Ack& ack) {
  for (const RejectedGame& game : ack.rejected) {
    log::Error("the learner rejected a game", "ticket", game.ticket, "reason", game.reason);
    parts_.outbox.Remove(game.ticket);
    parts_.tickets.Settle(game.ticket);
  }
  for (const std::uint64_t ticket : ack.durable) {
    parts_.outbox.Remove(ticket);
    parts_.tickets.Settle(ticket);
  }
  parts_.tickets.Grant(ack.tickets, ack.past_versions);
}

void Connection::Handle(const Goodbye& goodbye) {
  log::Info("the learner said goodbye", "reason", goodbye.reason, "run_complete",
            goodbye.run_complete);
  channel_->Send(Encode(Goodbye{.reason = "the learner said goodbye"}));
  end_ = goodbye.run_complete ? End::kOver : End::kRetry;
}

}  // namespace powderkeg

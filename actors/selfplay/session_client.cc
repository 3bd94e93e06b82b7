#include "actors/selfplay/session_client.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "common/base/check.h"
#include "common/base/log.h"
#include "common/wire/codec.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kNotConnectedPause{20};  // between two attempts to say Hello
constexpr std::size_t kBatchBytes = std::size_t{256} << 10;

}  // namespace

SessionClient::SessionClient(SessionClientSettings settings, Connect connect, Outbox& outbox,
                             TicketBook& tickets, std::function<Heartbeat()> statistics)
    : settings_(std::move(settings)),
      connect_(std::move(connect)),
      outbox_(outbox),
      tickets_(tickets),
      statistics_(std::move(statistics)),
      dead_after_(settings_.dead_after),
      rng_(settings_.incarnation) {
  tickets_.GrantPlayed(outbox_.Tickets());
  io_ = std::make_unique<Worker>("session", [this](const std::stop_token& stop) { Run(stop); });
}

SessionClient::~SessionClient() {
  try {
    Leave(milliseconds(0));
  } catch (const Error& error) {
    log::Error("session failed", "error", error.what());
  }
}

std::shared_ptr<const Welcome> SessionClient::welcome() const {
  const std::lock_guard lock(mutex_);
  return welcome_;
}

Snapshot SessionClient::weights() const {
  const std::lock_guard lock(mutex_);
  return weights_;
}

bool SessionClient::no_weights_yet() const {
  const std::lock_guard lock(mutex_);
  return no_weights_yet_;
}

std::uint64_t SessionClient::version() const {
  const std::lock_guard lock(mutex_);
  return version_;
}

void SessionClient::WaitForChange(std::uint64_t version, milliseconds timeout) const {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout, [&] { return version_ != version; });
}

void SessionClient::Leave(milliseconds patience) {
  {
    const std::lock_guard lock(mutex_);
    if (!deadline_) deadline_ = Clock::now() + patience;
  }
  io_->RequestStop();
  waker_.Notify();
  io_->Join();
}

std::optional<SessionClient::Clock::time_point> SessionClient::deadline() const {
  const std::lock_guard lock(mutex_);
  return deadline_;
}

void SessionClient::Changed() {
  {
    const std::lock_guard lock(mutex_);
    ++version_;
  }
  changed_.notify_all();
}

// --- The io thread -------------------------------------------------------------------------------

void SessionClient::Run(const std::stop_token& stop) {
  milliseconds backoff = settings_.first_backoff;
  Clock::time_point last_session = Clock::now();  // or when the search for one began
  const auto must_go = [&] {
    const auto last = deadline();
    return stop.stop_requested() && last && Clock::now() >= *last;
  };
  // Whatever ends this thread, nobody must wait for it in vain.
  const auto end = [this](void*) {
    ended_ = true;
    Changed();
  };
  const std::unique_ptr<void, decltype(end)> at_exit(this, end);
  do {
    Connection connection;
    connection.channel = connect_();
    if (Serve(connection) == End::kOver) return;
    connection.channel.reset();
    if (connection.welcomed) {
      backoff = settings_.first_backoff;
      last_session = connection.last_heard;
    }
    if (IsTooLong(Clock::now() - last_session)) {
      gave_up_ = true;
      return;
    }
    Pause(backoff);
    backoff = std::min(2 * backoff, settings_.last_backoff);
  } while (!must_go());
}

// Whether an actor that was for so long without a session gives up.
bool SessionClient::IsTooLong(Clock::duration absence) const {
  if (settings_.give_up <= milliseconds(0) || absence < settings_.give_up) return false;
  log::Warn("giving up: there was no session with the learner", "for_s",
            std::chrono::duration_cast<std::chrono::seconds>(absence).count());
  return true;
}

// Waits for the back-off, less up to half of it; not long when leaving.
void SessionClient::Pause(milliseconds backoff) {
  const Clock::time_point start = Clock::now();
  const auto jittered =
      std::chrono::duration_cast<milliseconds>(backoff * (1 - 0.5 * rng_.Uniform()));
  const auto left = [&] {
    const auto last = deadline();
    const Clock::time_point end =
        last ? std::min(start + settings_.first_backoff, *last) : start + jittered;
    return std::chrono::ceil<milliseconds>(end - Clock::now());
  };
  while (left() > milliseconds(0)) waker_.Wait(left());
}

SessionClient::End SessionClient::Serve(Connection& connection) {
  connection.last_heard = Clock::now();
  while (!connection.end) {
    if (!connection.greeted) Greet(connection);
    if (connection.welcomed) SendGames(connection);
    const Clock::time_point now = Clock::now();
    SendHeartbeat(connection, now);
    CheckDownload(connection, now);
    CheckLeaving(connection, now);
    CheckSilence(connection, now);
    if (connection.end) break;
    const milliseconds wait = connection.greeted ? heartbeat_ / 4 : kNotConnectedPause;
    auto bytes = connection.channel->Receive(wait, waker_);
    for (; bytes && !connection.end; bytes = connection.channel->Receive({}, waker_)) {
      connection.last_heard = Clock::now();
      Handle(connection, *bytes);
    }
  }
  return *connection.end;
}

// Tickets that only wait are not claimed: meanwhile they may have become others', and the learner
// grants what is open anew. Played all the same, they would be played twice, and before those that
// everybody waits for.
void SessionClient::Greet(Connection& connection) {
  connection.greeted = connection.channel->Send(Encode(Hello{.run_id = settings_.run_id,
                                                             .build = settings_.build,
                                                             .name = settings_.name,
                                                             .incarnation = settings_.incarnation,
                                                             .loops = settings_.loops,
                                                             .tickets = tickets_.Started()}));
  if (connection.greeted) tickets_.DropWaiting();  // until then they can be played
}

void SessionClient::SendGames(Connection& connection) {
  for (;;) {
    std::uint64_t cursor = connection.cursor;
    Games games{.games = outbox_.Batch(cursor, kBatchBytes)};
    if (games.games.empty() || !connection.channel->Send(Encode(games))) return;
    connection.cursor = cursor;
  }
}

void SessionClient::SendHeartbeat(Connection& connection, Clock::time_point now) {
  if (!connection.welcomed || now - connection.last_heartbeat < heartbeat_) return;
  connection.last_heartbeat = now;
  connection.channel->Send(Encode(statistics_()));
}

// Asks again for a chunk that does not come.
void SessionClient::CheckDownload(Connection& connection, Clock::time_point now) {
  if (!connection.welcomed || !download_) return;
  if (now - download_->requested_at >= dead_after_) RequestChunk(connection);
}

void SessionClient::CheckSilence(Connection& connection, Clock::time_point now) const {
  if (now - connection.last_heard < dead_after_) return;
  if (connection.greeted) {
    log::Warn("the learner is silent, trying again", "after_ms", dead_after_.count());
  } else {
    log::Warn("cannot reach the learner, trying again", "reason", connection.channel->Trouble());
  }
  connection.end = End::kRetry;
}

void SessionClient::CheckLeaving(Connection& connection, Clock::time_point now) {
  const auto last = deadline();
  if (!last || (outbox_.size() > 0 && now < *last)) return;
  if (outbox_.size() > 0) {
    log::Warn("leaving with games that are not acknowledged", "games", outbox_.size());
  }
  connection.channel->Send(Encode(Goodbye{.reason = "the actor ends"}));
  connection.end = End::kOver;
}

void SessionClient::Handle(Connection& connection, const std::string& bytes) {
  Decoded<WireMessage> decoded = Decode(bytes);
  if (const auto* malformed = std::get_if<Malformed>(&decoded)) {
    log::Warn("cannot read the learner", "reason", malformed->reason);
    connection.end = End::kRetry;
    return;
  }
  std::visit(
      [&](auto& message) {
        using Kind = std::decay_t<decltype(message)>;
        if constexpr (std::is_same_v<Kind, Hello> || std::is_same_v<Kind, Games> ||
                      std::is_same_v<Kind, WeightsRequest>) {
          log::Warn("the learner says what only actors say");
          connection.end = End::kRetry;
        } else if constexpr (!std::is_same_v<Kind, Heartbeat>) {
          Handle(connection, message);
        }
      },
      std::get<WireMessage>(decoded));
}

void SessionClient::Handle(Connection& connection, const Welcome& welcome) {
  log::Info("connected to the learner", "run", welcome.run_id);
  if (const auto aside = outbox_.ServeRun(welcome.run_id); !aside.empty()) {
    for (const std::uint64_t ticket : aside) tickets_.Settle(ticket);
    connection.end = End::kRetry;  // Hello has claimed them: the learner would wait for them
    return;
  }
  connection.welcomed = true;
  heartbeat_ = welcome.heartbeat;
  dead_after_ = welcome.dead_after;
  {
    const std::lock_guard lock(mutex_);
    if (!welcome_ || *welcome_ != welcome) welcome_ = std::make_shared<const Welcome>(welcome);
  }
  Changed();
  if (download_) RequestChunk(connection);  // goes on where it was
}

void SessionClient::Handle(Connection& connection, const Refused& refused) {
  if (!refused.retry) throw Error(StrCat("the learner refused this actor: ", refused.reason));
  log::Warn("the learner refused, trying again", "reason", refused.reason);
  connection.end = End::kRetry;
}

void SessionClient::Handle(Connection& /*connection*/, const Ack& ack) {
  for (const RejectedGame& game : ack.rejected) {
    log::Error("the learner rejected a game", "ticket", game.ticket, "reason", game.reason);
    outbox_.Remove(game.ticket);
    tickets_.Settle(game.ticket);
  }
  for (const std::uint64_t ticket : ack.durable) {
    outbox_.Remove(ticket);
    tickets_.Settle(ticket);
  }
  tickets_.Grant(ack.tickets);
}

void SessionClient::Handle(Connection& connection, const WeightsOffer& offer) {
  if (offer.version == 0) {
    download_.reset();
    held_.reset();
    {
      const std::lock_guard lock(mutex_);
      weights_ = nullptr;  // those of another run, if there are any
      no_weights_yet_ = true;
    }
    Changed();
    return;
  }
  if (held_ == offer) return;
  if (download_ && download_->offer == offer) return;
  download_ = Download{.offer = offer, .bytes = {}, .requested_at = {}};
  RequestChunk(connection);
}

void SessionClient::RequestChunk(Connection& connection) {
  download_->requested_at = Clock::now();
  connection.channel->Send(Encode(WeightsRequest{.version = download_->offer.version,
                                                 .offset_bytes = download_->bytes.size()}));
}

void SessionClient::Handle(Connection& connection, WeightsChunk& chunk) {
  if (!download_ || chunk.version != download_->offer.version ||
      chunk.offset_bytes != download_->bytes.size()) {
    return;  // of an older request
  }
  if (chunk.data.empty() ||
      chunk.data.size() > download_->offer.size_bytes - download_->bytes.size()) {
    log::Error("weights do not have the offered size", "version", chunk.version);
    download_.reset();
    connection.end = End::kRetry;
    return;
  }
  download_->bytes += chunk.data;
  if (download_->bytes.size() < download_->offer.size_bytes) {
    RequestChunk(connection);
  } else {
    FinishDownload(connection);
  }
}

// Damaged weights are fetched again on a new connection, after the back-off.
void SessionClient::FinishDownload(Connection& connection) {
  const Download download = *std::exchange(download_, std::nullopt);
  try {
    if (Sha256(BytesOf(download.bytes)) != download.offer.sha256) {
      throw Error("the SHA-256 does not fit");
    }
    auto snapshot = std::make_shared<const WeightsSnapshot>(Deserialize(BytesOf(download.bytes)));
    if (snapshot->version != download.offer.version) throw Error("the version does not fit");
    held_ = download.offer;
    const std::lock_guard lock(mutex_);
    weights_ = std::move(snapshot);
  } catch (const Error& error) {
    log::Error("weights refused", "version", download.offer.version, "reason", error.what());
    connection.end = End::kRetry;
    return;
  }
  log::Info("received weights", "version", download.offer.version, "bytes",
            download.offer.size_bytes);
  Changed();
}

void SessionClient::Handle(Connection& connection, const Goodbye& goodbye) {
  log::Info("the learner said goodbye", "reason", goodbye.reason, "run_complete",
            goodbye.run_complete);
  connection.channel->Send(Encode(Goodbye{.reason = "the learner said goodbye"}));
  connection.end = goodbye.run_complete ? End::kOver : End::kRetry;
}

}  // namespace powderkeg

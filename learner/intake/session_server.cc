#include "learner/intake/session_server.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <variant>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/log.h"
#include "common/config/config.h"
#include "common/wire/codec.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;

constexpr int kMessagesPerRound = 256;    // received before verdicts are looked at again
constexpr int kChunksPerRound = 16;       // of weights that are sent meanwhile
constexpr std::size_t kAckEntries = 512;  // per message
constexpr int kTicksPerHeartbeat = 10;
constexpr std::size_t kSessionsPerHeartbeat = 1000;  // more have longer ones

// How many times longer than with few sessions.
int HeartbeatFactor(std::size_t sessions) {
  return static_cast<int>(1 + sessions / kSessionsPerHeartbeat);
}

TicketSet Durable(std::span<const std::uint64_t> known, std::uint64_t first_open) {
  TicketSet tickets(first_open);
  for (const std::uint64_t ticket : known) tickets.Insert(ticket);
  return tickets;
}

PipelineSettings PipelineSettingsOf(const SessionServerSettings& settings) {
  PipelineSettings pipeline;
  pipeline.self_play = settings.self_play;
  pipeline.verify_threads = settings.verify_threads;
  pipeline.commit_interval = settings.commit_interval;
  pipeline.capacity = settings.max_pending_games;
  pipeline.newest_version = settings.newest_version;
  return pipeline;
}

}  // namespace

SessionServer::SessionServer(SessionServerSettings settings, std::unique_ptr<ServerChannel> channel,
                             AppendGames append, std::span<const std::uint64_t> known,
                             std::uint64_t first_open)
    : settings_(std::move(settings)),
      settings_digest_(SettingsDigest(settings_.self_play)),
      channel_(std::move(channel)),
      office_(known, first_open),
      tickets_({.games_in_flight = settings_.self_play.games_in_flight,
                .overdue_after = settings_.overdue_after,
                .patient = !settings_.games_always_wanted,
                .games_wanted = settings_.games_wanted},
               office_),
      weights_(settings_.load_weights, settings_.weights_kept),
      endpoint_(channel_->endpoint()),
      pipeline_(PipelineSettingsOf(settings_), std::move(append), Durable(known, first_open),
                waker_),
      games_(office_, tickets_, peers_, pipeline_) {
  io_ = std::make_unique<Worker>("intake", [this](const std::stop_token& stop) { RunIo(stop); });
}

SessionServer::~SessionServer() {
  try {
    Stop({.reason = "the learner ends"});
  } catch (const Error& error) {
    log::Error("session server failed", "error", error.what());
  }
}

void SessionServer::Publish(const Snapshot& snapshot) {
  if (snapshot) pipeline_.Published(snapshot->version);
  weights_.Publish(snapshot);
  waker_.Notify();
}

IntakeStatistics SessionServer::statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

bool SessionServer::failed() const { return pipeline_.failed() || (io_->finished() && !stopping_); }

void SessionServer::Stop(const Goodbye& goodbye) {
  {
    const std::lock_guard lock(mutex_);
    if (!stopping_) goodbye_ = goodbye;
  }
  stopping_ = true;
  std::exception_ptr error;
  try {
    pipeline_.Drain();
  } catch (const Error&) {
    error = std::current_exception();
  }
  io_->RequestStop();
  waker_.Notify();
  io_->Join();
  if (error) std::rethrow_exception(error);
}

// --- The io thread -------------------------------------------------------------------------------

void SessionServer::RunIo(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    ReceiveSome();
    AnswerRequests();
    HandleVerdicts();
    if (weights_.Refresh()) SendToAll(*weights_.offer());
    const Clock::time_point now = Clock::now();
    if (now - last_tick_ >= TickInterval()) Tick(now);
  }
  HandleVerdicts();
  TakeLeave();
  UpdateStatistics(Clock::now());
  channel_.reset();  // the address is free
}

// Actors answer Goodbye with Goodbye, which ends their sessions.
void SessionServer::TakeLeave() {
  Goodbye goodbye;
  {
    const std::lock_guard lock(mutex_);
    goodbye = goodbye_;
  }
  SendToAll(goodbye);
  const Clock::time_point end = Clock::now() + settings_.goodbye_patience;
  while (peers_.size() > 0) {
    const auto left = std::chrono::ceil<milliseconds>(end - Clock::now());
    if (left <= milliseconds(0)) break;
    if (auto incoming = channel_->Receive(left, waker_)) Handle(*incoming);
  }
  for (const auto& [id, session] : peers_.sessions()) {
    if (!log_budget_.Spend()) break;
    log::Warn("an actor does not answer Goodbye", "name", session.hello.name);
  }
}

bool SessionServer::Full() const {
  return games_.counters().pending_games >= settings_.max_pending_games / 2 ||
         games_.counters().pending_bytes >= settings_.max_pending_bytes;
}

void SessionServer::ReceiveSome() {
  const milliseconds tick = TickInterval();
  if (Full()) {
    waker_.Wait(tick);
    return;
  }
  for (int i = 0; i < kMessagesPerRound && !Full(); ++i) {
    const bool idle = i == 0 && requests_.empty();
    auto incoming = channel_->Receive(idle ? tick : milliseconds(0), waker_);
    if (!incoming) {
      caught_up_ = Clock::now();
      return;
    }
    Handle(*incoming);
    if (i > 0 && Clock::now() - last_tick_ >= tick) return;
  }
}

void SessionServer::Handle(Incoming& incoming) {
  Decoded<WireMessage> decoded = Decode(incoming.bytes);
  if (const auto* malformed = std::get_if<Malformed>(&decoded)) {
    ++malformed_;
    Refuse(incoming.peer, {.reason = malformed->reason, .retry = true});
    return;
  }
  auto& message = std::get<WireMessage>(decoded);
  Session* session = peers_.FindPeer(incoming.peer);
  if (session != nullptr) {
    HandleFrom(*session, message);
  } else if (const auto* hello = std::get_if<Hello>(&message)) {
    OpenSession(incoming, *hello);
  } else if (!std::holds_alternative<Goodbye>(message)) {
    Refuse(incoming.peer, {.reason = "there is no session: say Hello", .retry = true});
  }
}

void SessionServer::HandleFrom(Session& session, WireMessage& message) {
  session.last_heard = Clock::now();
  if (auto* games = std::get_if<Games>(&message)) {
    TakeGames(session, *games);
  } else if (const auto* heartbeat = std::get_if<Heartbeat>(&message)) {
    session.heartbeat = *heartbeat;
  } else if (const auto* request = std::get_if<WeightsRequest>(&message)) {
    TakeRequest(session, *request);
  } else if (const auto* goodbye = std::get_if<Goodbye>(&message)) {
    if (log_budget_.Spend()) {
      log::Info("actor left", "name", session.hello.name, "reason", goodbye->reason);
    }
    EndSession(session);
  } else {
    ++malformed_;
    Refuse(session.peer, {.reason = "only learners say that, or it said Hello", .retry = true});
  }
}

std::optional<Refused> SessionServer::Objection(const Hello& hello,
                                                const std::string& key_owner) const {
  if (hello.protocol_version != kProtocolVersion) {
    return Refused{.reason = StrCat("its protocol version is ", hello.protocol_version,
                                    "; expected ", kProtocolVersion)};
  }
  if (!hello.run_id.empty() && hello.run_id != settings_.run_id) {
    return Refused{
        .reason = StrCat("its run is \"", hello.run_id, "\"; expected \"", settings_.run_id, "\"")};
  }
  if (!key_owner.empty() && hello.name != key_owner) {
    return Refused{.reason = StrCat("its key is that of actor \"", key_owner, "\"; its name is \"",
                                    hello.name, "\"")};
  }
  if (stopping_) return Refused{.reason = "the learner ends", .retry = true};
  return std::nullopt;
}

void SessionServer::OpenSession(const Incoming& incoming, const Hello& hello) {
  const PeerId& peer = incoming.peer;
  if (const auto objection = Objection(hello, incoming.key_owner)) {
    Refuse(peer, *objection);
    return;
  }
  ReplaceNamesake(hello);
  if (peers_.size() >= settings_.max_sessions) {
    Refuse(peer,
           {.reason = StrCat("there are ", peers_.size(), " sessions already"), .retry = true});
    return;
  }
  Session& session = peers_.Open(peer, hello);
  const SessionId id = session.id;
  const int factor = HeartbeatFactor(peers_.size());
  session.heartbeat_interval = factor * settings_.heartbeat;
  session.dead_after = factor * settings_.dead_after;
  tickets_.Open(id, hello.loops, hello.tickets);
  if (log_budget_.Spend()) {
    log::Info("actor connected", "name", hello.name, "build", hello.build, "loops", hello.loops,
              "tickets", hello.tickets.size());
  }
  Send(id, Welcome{.run_id = settings_.run_id,
                   .self_play = settings_.self_play,
                   .settings_digest = settings_digest_,
                   .heartbeat = session.heartbeat_interval,
                   .dead_after = session.dead_after});
  SendAck(id, {});
  if (const auto offer = weights_.offer()) Send(id, *offer);
}

void SessionServer::ReplaceNamesake(const Hello& hello) {
  const Session* namesake = peers_.FindName(hello.name);
  if (namesake == nullptr) return;
  if (namesake->hello.incarnation == hello.incarnation) {
    EndSession(*namesake);  // it comes back on a fresh connection
  } else {
    Refuse(namesake->peer, {.reason = "another actor of this name has connected"});
  }
}

void SessionServer::TakeGames(Session& session, Games& games) {
  if (stopping_) return;  // they come again after the restart
  Ack ack;
  for (SealedGame& game : games.games) {
    if (games_.Admit(session, std::move(game), ack)) continue;
    Refuse(session.peer,
           {.reason = "more games than tickets, or the learner is full", .retry = true});
    return;
  }
  if (ack != Ack{}) SendAck(session.id, std::move(ack));
}

// Whoever asks for the next chunk has the receipt of the last: so one lies unread at most.
void SessionServer::TakeRequest(Session& session, const WeightsRequest& request) {
  if (request.receipt != session.receipt) {
    Refuse(session.peer,
           {.reason = "it asks for weights before it has read the last ones", .retry = true});
    return;
  }
  session.receipt = NextReceipt();
  requests_.emplace_back(session.id, request);
}

// Nobody can foretell it from those that it was given.
std::uint64_t SessionServer::NextReceipt() {
  const Sha256Digest digest = Sha256(BytesOf(StrCat(receipt_secret_, ' ', ++receipts_)));
  std::uint64_t receipt = 0;
  std::memcpy(&receipt, digest.data(), sizeof receipt);
  return std::max<std::uint64_t>(receipt, 1);
}

void SessionServer::AnswerRequests() {
  for (int sent = 0; sent < kChunksPerRound && !requests_.empty();) {
    const auto [id, request] = requests_.front();
    requests_.pop_front();
    const Session* const session = peers_.Find(id);
    if (session == nullptr) continue;
    ++sent;
    const WeightsReceipt receipt{session->receipt};
    Sent(id, channel_->SendShared(session->peer, weights_.Answer(request)));
    Send(id, receipt);
  }
}

void SessionServer::HandleVerdicts() {
  for (auto& [id, ack] : games_.Settle()) {
    SendAck(id, std::move(ack));
    const Session* session = peers_.Find(id);
    if (session != nullptr && session->rejected > settings_.max_rejected_games) {
      Refuse(session->peer, {.reason = "too many of its games were rejected"});
    }
  }
}

void SessionServer::SendAck(SessionId id, Ack ack) {
  const Session* const session = peers_.Find(id);
  if (session == nullptr) return;  // it did not take a message and was ended
  const auto offer = weights_.offer();
  const bool outdated = settings_.newest_weights_only && offer &&
                        session->heartbeat.weights_version != offer->version;
  if (!stopping_ && !outdated) ack.tickets = tickets_.TopUp(id);
  if (settings_.draw_past) {
    ack.past_versions.resize(ack.tickets.size());
    std::ranges::generate(ack.past_versions, settings_.draw_past);
  }
  const auto part = [](const auto& all, std::size_t first) {
    const std::size_t begin = std::min(first, all.size());
    const std::size_t end = std::min(first + kAckEntries, all.size());
    return std::vector(all.begin() + static_cast<std::ptrdiff_t>(begin),
                       all.begin() + static_cast<std::ptrdiff_t>(end));
  };
  const std::size_t entries =
      std::max({ack.durable.size(), ack.rejected.size(), ack.tickets.size()});
  for (std::size_t first = 0; first < entries; first += kAckEntries) {
    Send(id, Ack{.durable = part(ack.durable, first),
                 .rejected = part(ack.rejected, first),
                 .tickets = part(ack.tickets, first),
                 .past_versions = part(ack.past_versions, first)});
  }
}

void SessionServer::Tick(Clock::time_point now) {
  last_tick_ = now;
  EndSilentSessions(now);
  for (const auto& [id, tickets] : tickets_.TakeBackOverdue(now)) {
    log::Warn("games are overdue, others play them too", "actor", peers_.Find(id)->hello.name,
              "games", tickets, "held_s_at_least", settings_.overdue_after.count() / 1000);
  }
  for (const SessionId id : peers_.Ids()) {
    const Session& session = *peers_.Find(id);
    if (now - session.last_sent >= session.heartbeat_interval) Send(id, Heartbeat{});
    SendAck(id, {});  // new games may be wanted again, or a lost game's ticket open
  }
  UpdateStatistics(now);
}

milliseconds SessionServer::TickInterval() const {
  return HeartbeatFactor(peers_.size()) * settings_.heartbeat / kTicksPerHeartbeat;
}

// Silence counts only up to when everything that had arrived was read.
void SessionServer::EndSilentSessions(Clock::time_point now) {
  const Clock::time_point heard_until = std::min(now, caught_up_);
  for (const SessionId id : peers_.Ids()) {
    const Session& session = *peers_.Find(id);
    if (heard_until - session.last_heard < session.dead_after) continue;
    ++sessions_lost_;
    if (log_budget_.Spend()) {
      log::Warn("lost an actor", "name", session.hello.name, "silence_ms",
                session.dead_after.count());
    }
    EndSession(session);
  }
}

void SessionServer::UpdateStatistics(Clock::time_point now) {
  IntakeStatistics statistics;
  static_cast<GameCounters&>(statistics) = games_.counters();
  statistics.malformed = malformed_;
  statistics.sessions_lost = sessions_lost_;
  statistics.tickets_issued = office_.issued();
  statistics.first_open_ticket = office_.first_open();
  for (const auto& [id, session] : peers_.sessions()) {
    statistics.actors.push_back(
        {.name = session.hello.name,
         .heartbeat = session.heartbeat,
         .silence = std::chrono::duration_cast<milliseconds>(now - session.last_heard),
         .tickets = office_.held(id),
         .games = session.games,
         .rejected = session.rejected});
  }
  std::ranges::sort(statistics.actors, {}, &ActorStatistics::name);
  const std::lock_guard lock(mutex_);
  statistics_ = std::move(statistics);
}

void SessionServer::Send(SessionId id, const WireMessage& message) {
  const Session* session = peers_.Find(id);
  if (session == nullptr) return;  // ended by a message just before
  Sent(id, channel_->Send(session->peer, Encode(message)));
}

void SessionServer::Sent(SessionId id, bool taken) {
  Session* session = peers_.Find(id);
  if (taken) {
    session->last_sent = Clock::now();
    return;
  }
  if (log_budget_.Spend()) {
    log::Warn("an actor does not take messages", "name", session->hello.name);
  }
  EndSession(*session);
}

void SessionServer::SendToAll(const WireMessage& message) {
  for (const SessionId id : peers_.Ids()) Send(id, message);
}

void SessionServer::Refuse(const PeerId& peer, const Refused& refused) {
  const PeerId refused_peer = peer;  // `peer` may be of the session that ends
  const Session* session = peers_.FindPeer(peer);
  if (log_budget_.Spend()) {
    log::Warn("refused a peer", "name", session == nullptr ? "" : session->hello.name, "reason",
              refused.reason);
  }
  if (session != nullptr) EndSession(*session);
  channel_->Send(refused_peer, Encode(refused));
}

void SessionServer::EndSession(const Session& session) {
  const SessionId id = session.id;
  tickets_.Close(id);
  peers_.Close(id);
}

}  // namespace powderkeg

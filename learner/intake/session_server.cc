#include "learner/intake/session_server.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "common/base/check.h"
#include "common/base/log.h"
#include "common/config/config.h"
#include "common/wire/codec.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;

constexpr int kMessagesPerRound = 256;     // received before verdicts are looked at again
constexpr int kLogLinesPerSecond = 10;     // about bad peers
constexpr std::size_t kAckEntries = 2048;  // per message
constexpr std::size_t kMostTickets = kMaxTickets / 2;  // that a session may hold
constexpr int kTicksPerHeartbeat = 10;

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
  return pipeline;
}

}  // namespace

std::size_t TicketTarget(std::uint32_t loops, int games_in_flight) {
  const std::size_t playing = std::size_t{loops} * static_cast<std::size_t>(games_in_flight);
  return std::min(playing + std::max<std::size_t>(4, playing / 4), kMostTickets);
}

bool SessionServer::LogBudget::Spend(Clock::time_point now) {
  if (now - second >= std::chrono::seconds(1)) {
    second = now;
    left = kLogLinesPerSecond;
  }
  return left-- > 0;
}

SessionServer::SessionServer(SessionServerSettings settings, std::unique_ptr<ServerChannel> channel,
                             AppendGames append, std::span<const std::uint64_t> known,
                             std::uint64_t first_open)
    : settings_(std::move(settings)),
      settings_digest_(SettingsDigest(settings_.self_play)),
      channel_(std::move(channel)),
      office_(known, first_open),
      last_overdue_(Clock::now()),
      caught_up_(last_overdue_),
      endpoint_(channel_->endpoint()),
      pipeline_(PipelineSettingsOf(settings_), std::move(append), Durable(known, first_open),
                waker_) {
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
  auto published = std::make_shared<PublishedWeights>();
  if (snapshot) {
    const std::vector<std::uint8_t> bytes = Serialize(*snapshot);
    if (bytes.size() > kMaxWeightsBytes) {
      throw Error(
          StrCat("weights of ", bytes.size(), " bytes; expected at most ", kMaxWeightsBytes));
    }
    published->offer = {
        .version = snapshot->version, .size_bytes = bytes.size(), .sha256 = Sha256(bytes)};
    published->bytes.assign(bytes.begin(), bytes.end());
  }
  {
    const std::lock_guard lock(mutex_);
    newest_ = std::move(published);
  }
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
  const milliseconds tick = settings_.heartbeat / kTicksPerHeartbeat;
  while (!stop.stop_requested()) {
    ReceiveSome();
    HandleVerdicts();
    OfferNewWeights();
    const Clock::time_point now = Clock::now();
    if (now - last_tick_ >= tick) Tick(now);
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
  while (!sessions_.empty()) {
    const auto left = std::chrono::ceil<milliseconds>(end - Clock::now());
    if (left <= milliseconds(0)) break;
    if (auto incoming = channel_->Receive(left, waker_)) Handle(*incoming);
  }
  for (const auto& [peer, session] : sessions_) {
    log::Warn("an actor does not answer Goodbye", "name", session.hello.name);
  }
}

bool SessionServer::Full() const {
  return pending_games_ >= settings_.max_pending_games / 2 ||
         pending_bytes_ >= settings_.max_pending_bytes;
}

void SessionServer::ReceiveSome() {
  const milliseconds tick = settings_.heartbeat / kTicksPerHeartbeat;
  if (Full()) {
    waker_.Wait(tick);
    return;
  }
  for (int i = 0; i < kMessagesPerRound && !Full(); ++i) {
    auto incoming = channel_->Receive(i == 0 ? tick : milliseconds(0), waker_);
    if (!incoming) {
      caught_up_ = Clock::now();
      return;
    }
    Handle(*incoming);
  }
}

void SessionServer::Handle(Incoming& incoming) {
  Decoded<WireMessage> decoded = Decode(incoming.bytes);
  if (const auto* malformed = std::get_if<Malformed>(&decoded)) {
    ++counters_.malformed;
    Refuse(incoming.peer, {.reason = malformed->reason, .retry = true});
    return;
  }
  auto& message = std::get<WireMessage>(decoded);
  if (const auto* hello = std::get_if<Hello>(&message)) {
    OpenSession(incoming.peer, *hello);
  } else if (sessions_.contains(incoming.peer)) {
    HandleSessionMessage(incoming.peer, message);
  } else if (!std::holds_alternative<Goodbye>(message)) {
    Refuse(incoming.peer, {.reason = "there is no session: say Hello", .retry = true});
  }
}

void SessionServer::HandleSessionMessage(const PeerId& peer, WireMessage& message) {
  Session& session = sessions_.at(peer);
  session.last_heard = Clock::now();
  if (auto* games = std::get_if<Games>(&message)) {
    TakeGames(peer, *games);
  } else if (const auto* heartbeat = std::get_if<Heartbeat>(&message)) {
    session.heartbeat = *heartbeat;
  } else if (const auto* request = std::get_if<WeightsRequest>(&message)) {
    SendChunk(peer, *request);
  } else if (const auto* goodbye = std::get_if<Goodbye>(&message)) {
    log::Info("actor left", "name", session.hello.name, "reason", goodbye->reason);
    EndSession(peer);
  } else {
    ++counters_.malformed;
    Refuse(peer, {.reason = "only learners say that", .retry = true});
  }
}

std::optional<Refused> SessionServer::Objection(const Hello& hello) const {
  if (hello.protocol_version != kProtocolVersion) {
    return Refused{.reason = StrCat("its protocol version is ", hello.protocol_version,
                                    "; expected ", kProtocolVersion)};
  }
  if (!hello.run_id.empty() && hello.run_id != settings_.run_id) {
    return Refused{
        .reason = StrCat("its run is \"", hello.run_id, "\"; expected \"", settings_.run_id, "\"")};
  }
  if (stopping_) return Refused{.reason = "the learner ends", .retry = true};
  return std::nullopt;
}

void SessionServer::OpenSession(const PeerId& peer, const Hello& hello) {
  EndSession(peer);  // a second Hello starts anew
  if (const auto objection = Objection(hello)) {
    Refuse(peer, *objection);
    return;
  }
  ReplaceNamesake(hello);
  if (sessions_.size() >= settings_.max_sessions) {
    Refuse(peer,
           {.reason = StrCat("there are ", sessions_.size(), " sessions already"), .retry = true});
    return;
  }
  Session& session = sessions_[peer];
  session.id = ++last_session_;
  session.hello = hello;
  session.hello.tickets.clear();
  session.last_heard = session.last_sent = Clock::now();
  peers_[session.id] = peer;
  log::Info("actor connected", "name", hello.name, "build", hello.build, "loops", hello.loops,
            "tickets", hello.tickets.size());
  office_.Claim(session.id, hello.tickets);
  SendToSession(peer, Welcome{.run_id = settings_.run_id,
                              .self_play = settings_.self_play,
                              .settings_digest = settings_digest_,
                              .heartbeat = settings_.heartbeat,
                              .dead_after = settings_.dead_after});
  Ack ack;
  TopUp(peer, ack);
  SendAck(peer, ack);
  if (offered_) SendToSession(peer, offered_->offer);
}

void SessionServer::ReplaceNamesake(const Hello& hello) {
  const auto namesake = std::find_if(sessions_.begin(), sessions_.end(), [&](const auto& entry) {
    return entry.second.hello.name == hello.name;
  });
  if (namesake == sessions_.end()) return;
  const PeerId peer = namesake->first;
  if (namesake->second.hello.incarnation == hello.incarnation) {
    EndSession(peer);  // it comes back on a fresh connection
  } else {
    Refuse(peer, {.reason = "another actor of this name has connected"});
  }
}

void SessionServer::TakeGames(const PeerId& peer, Games& games) {
  Ack ack;
  for (SealedGame& game : games.games) {
    if (!Admit(sessions_.at(peer), game, ack)) {
      Refuse(peer, {.reason = "more games than tickets, or the learner is full", .retry = true});
      return;
    }
  }
  if (!ack.durable.empty() || !ack.rejected.empty()) {
    TopUp(peer, ack);
    SendAck(peer, ack);
  }
}

// Puts a game into the pipeline, or its answer into the ack. False: the session has no right to
// send so many.
bool SessionServer::Admit(Session& session, SealedGame& game, Ack& ack) {
  using Standing = TicketOffice::Standing;
  switch (office_.StandingOf(game.ticket)) {
    case Standing::kDurable:
      ++counters_.duplicates;
      session.overdue = false;
      ack.durable.push_back(game.ticket);
      return true;
    case Standing::kNeverIssued:
      ++counters_.rejected;
      ack.rejected.push_back({.ticket = game.ticket, .reason = "the ticket was never issued"});
      return ++session.rejected <= settings_.max_rejected_games;
    case Standing::kAwaited: break;
  }
  if (session.pending >= kMostTickets) return false;
  if (stopping_) return true;  // it comes again after the restart
  const std::size_t bytes = game.record.size();
  if (!pipeline_.Submit(session.id, std::move(game))) return false;
  ++session.pending;
  ++pending_games_;
  pending_bytes_ += bytes;
  return true;
}

void SessionServer::SendChunk(const PeerId& peer, const WeightsRequest& request) {
  if (!offered_) return;
  if (request.version != offered_->offer.version ||
      request.offset_bytes >= offered_->bytes.size()) {
    SendToSession(peer, offered_->offer);
    return;
  }
  // It asks for the next chunk when it has one, so more than this was not read, or lost by it.
  std::uint64_t& sent = sessions_.at(peer).weights_bytes;
  if (sent > 2 * offered_->bytes.size()) {
    Refuse(peer, {.reason = "it asks for the same weights again and again", .retry = true});
    return;
  }
  sent += std::min<std::uint64_t>(kMaxChunkBytes, offered_->bytes.size() - request.offset_bytes);
  SendToSession(peer,
                WeightsChunk{.version = request.version,
                             .offset_bytes = request.offset_bytes,
                             .data = offered_->bytes.substr(request.offset_bytes, kMaxChunkBytes)});
}

void SessionServer::HandleVerdicts() {
  std::map<PeerId, Ack> acks;
  for (const Verdict& verdict : pipeline_.TakeVerdicts()) Settle(verdict, acks);
  for (auto& [peer, ack] : acks) {
    const Session& session = sessions_.at(peer);
    const bool refuse = session.rejected > settings_.max_rejected_games;
    if (!refuse) TopUp(peer, ack);
    SendAck(peer, ack);
    if (refuse) Refuse(peer, {.reason = "too many of its games were rejected"});
  }
}

void SessionServer::Settle(const Verdict& verdict, std::map<PeerId, Ack>& acks) {
  --pending_games_;
  pending_bytes_ -= verdict.bytes;
  const bool rejected = verdict.kind == Verdict::Kind::kRejected;
  if (rejected) {
    ++counters_.rejected;
    office_.Reject(verdict.session, verdict.ticket);
  } else {
    office_.Complete(verdict.ticket);
  }
  if (verdict.kind == Verdict::Kind::kDuplicate) ++counters_.duplicates;
  if (verdict.kind == Verdict::Kind::kDurable) {
    ++counters_.games;
    counters_.decisions += verdict.decisions;
    counters_.other_settings += verdict.other_settings ? 1 : 0;
  }
  const auto peer = peers_.find(verdict.session);
  if (peer == peers_.end()) return;  // it left meanwhile; it will ask again
  Session& session = sessions_.at(peer->second);
  --session.pending;
  Ack& ack = acks[peer->second];
  if (rejected) {
    if (!verdict.outdated) ++session.rejected;
    ack.rejected.push_back({.ticket = verdict.ticket, .reason = verdict.reason});
    if (log_budget_.Spend(Clock::now())) {
      log::Warn("rejected a game", "actor", session.hello.name, "ticket", verdict.ticket, "reason",
                verdict.reason);
    }
  } else {
    ++session.games;
    session.overdue = false;
    ack.durable.push_back(verdict.ticket);
  }
}

void SessionServer::TopUp(const PeerId& peer, Ack& ack) {
  const auto found = sessions_.find(peer);
  if (found == sessions_.end()) return;  // it did not take a message and was ended
  const Session& session = found->second;
  const std::size_t target = TicketTarget(session.hello.loops, settings_.self_play.games_in_flight);
  const std::size_t held = office_.held(session.id);
  if (held >= target || session.overdue || stopping_) return;
  const std::size_t share = std::max(held, ShareOf(session));
  ack.tickets = office_.Grant(session.id, target - held, share - held);
}

// The games that a session may have in play of all that are wanted, rounded up: where actors could
// play more than that, all of them play fewer games at once.
std::size_t SessionServer::ShareOf(const Session& session) const {
  const std::uint64_t wanted = settings_.games_wanted();
  if (wanted == SessionServerSettings::kAllGames) return kMostTickets;
  std::uint64_t loops = 0;
  for (const auto& [peer, other] : sessions_) loops += other.hello.loops;
  const double share =
      static_cast<double>(wanted) * session.hello.loops / static_cast<double>(loops);
  return static_cast<std::size_t>(std::min<double>(std::ceil(share), kMostTickets));
}

// In as many messages as it takes.
void SessionServer::SendAck(const PeerId& peer, const Ack& ack) {
  const auto part = [](const auto& all, std::size_t first) {
    const std::size_t begin = std::min(first, all.size());
    const std::size_t end = std::min(first + kAckEntries, all.size());
    return std::vector(all.begin() + static_cast<std::ptrdiff_t>(begin),
                       all.begin() + static_cast<std::ptrdiff_t>(end));
  };
  const std::size_t entries =
      std::max({ack.durable.size(), ack.rejected.size(), ack.tickets.size()});
  for (std::size_t first = 0; first < entries; first += kAckEntries) {
    SendToSession(peer, Ack{.durable = part(ack.durable, first),
                            .rejected = part(ack.rejected, first),
                            .tickets = part(ack.tickets, first)});
  }
}

void SessionServer::OfferNewWeights() {
  std::shared_ptr<const PublishedWeights> newest;
  {
    const std::lock_guard lock(mutex_);
    newest = newest_;
  }
  if (newest == offered_) return;
  offered_ = std::move(newest);
  for (auto& [peer, session] : sessions_) session.weights_bytes = 0;
  SendToAll(offered_->offer);
}

void SessionServer::Tick(Clock::time_point now) {
  last_tick_ = now;
  EndSilentSessions(now);
  std::vector<PeerId> due;
  for (const auto& [peer, session] : sessions_) {
    if (now - session.last_sent >= settings_.heartbeat) due.push_back(peer);
  }
  for (const PeerId& peer : due) SendToSession(peer, Heartbeat{});
  TakeBackOverdue(now);
  TopUpEverybody();
  UpdateStatistics(now);
}

// As long as new games are wanted nobody is idle, and a slow actor has all the time it needs.
void SessionServer::TakeBackOverdue(Clock::time_point now) {
  if (now - last_overdue_ < settings_.overdue_after) return;
  last_overdue_ = now;
  if (settings_.games_wanted() > 0) return;
  for (const auto& [id, tickets] : office_.TakeBackOverdue()) {
    Session& session = sessions_.at(peers_.at(id));
    session.overdue = true;
    log::Warn("games are overdue, others play them too", "actor", session.hello.name, "games",
              tickets, "held_s_at_least", settings_.overdue_after.count() / 1000);
  }
}

void SessionServer::TopUpEverybody() {
  std::map<PeerId, Ack> acks;
  for (const auto& [peer, session] : sessions_) TopUp(peer, acks[peer]);
  for (const auto& [peer, ack] : acks) SendAck(peer, ack);
}

// Silence counts only up to when everything that had arrived was read.
void SessionServer::EndSilentSessions(Clock::time_point now) {
  const Clock::time_point heard_until = std::min(now, caught_up_);
  std::vector<PeerId> silent;
  for (const auto& [peer, session] : sessions_) {
    if (heard_until - session.last_heard >= settings_.dead_after) silent.push_back(peer);
  }
  for (const PeerId& peer : silent) {
    ++counters_.sessions_lost;
    log::Warn("lost an actor", "name", sessions_.at(peer).hello.name, "silence_ms",
              settings_.dead_after.count());
    EndSession(peer);
  }
}

void SessionServer::UpdateStatistics(Clock::time_point now) {
  IntakeStatistics statistics = counters_;
  statistics.pending_games = pending_games_;
  statistics.tickets_issued = office_.issued();
  statistics.first_open_ticket = office_.first_open();
  for (const auto& [peer, session] : sessions_) {
    statistics.actors.push_back(
        {.name = session.hello.name,
         .heartbeat = session.heartbeat,
         .silence = std::chrono::duration_cast<milliseconds>(now - session.last_heard),
         .tickets = office_.held(session.id),
         .games = session.games,
         .rejected = session.rejected});
  }
  std::sort(statistics.actors.begin(), statistics.actors.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  const std::lock_guard lock(mutex_);
  statistics_ = std::move(statistics);
}

void SessionServer::SendToSession(const PeerId& peer, const WireMessage& message) {
  const auto session = sessions_.find(peer);
  if (session == sessions_.end()) return;  // ended by a message just before
  if (channel_->Send(peer, Encode(message))) {
    session->second.last_sent = Clock::now();
    return;
  }
  log::Warn("an actor does not take messages", "name", session->second.hello.name);
  EndSession(peer);
}

void SessionServer::SendToAll(const WireMessage& message) {
  std::vector<PeerId> peers;
  for (const auto& [peer, session] : sessions_) peers.push_back(peer);
  for (const PeerId& peer : peers) SendToSession(peer, message);
}

void SessionServer::Refuse(const PeerId& peer, const Refused& refused) {
  const auto session = sessions_.find(peer);
  if (log_budget_.Spend(Clock::now())) {
    log::Warn("refused a peer", "name",
              session == sessions_.end() ? "" : session->second.hello.name, "reason",
              refused.reason);
  }
  EndSession(peer);
  channel_->Send(peer, Encode(refused));
}

void SessionServer::EndSession(const PeerId& peer) {
  const auto session = sessions_.find(peer);
  if (session == sessions_.end()) return;
  office_.Release(session->second.id);
  peers_.erase(session->second.id);
  sessions_.erase(session);
}

}  // namespace powderkeg

#pragma once

// The learner's side of the session (proto/wire.proto): takes games in, hands weights out.

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/base/log_budget.h"
#include "common/base/unique.h"
#include "common/base/worker.h"
#include "common/config/run_config.h"
#include "common/model/weights_snapshot.h"
#include "common/wire/messages.h"
#include "common/wire/transport.h"
#include "learner/intake/game_desk.h"
#include "learner/intake/game_pipeline.h"
#include "learner/intake/peer_table.h"
#include "learner/intake/ticket_desk.h"
#include "learner/intake/ticket_office.h"
#include "learner/intake/weights_desk.h"

namespace powderkeg {

struct SessionServerSettings {
  std::string run_id;
  SelfPlayConfig self_play;
  // Of up to a thousand sessions; with n thousand both are n times as long, so that signs of life
  // take the same time however many actors there are.
  std::chrono::milliseconds heartbeat{1000};
  std::chrono::milliseconds dead_after{5000};
  // A game waits at most this long for others to be made durable with it.
  std::chrono::milliseconds commit_interval{250};
  int verify_threads = 1;
  std::size_t max_sessions = 16'384;
  // Games received and not yet durable. Beyond one of these the server stops reading until some
  // are: actors then run out of tickets and pause.
  std::size_t max_pending_games = 65'536;
  std::size_t max_pending_bytes = std::size_t{256} << 20;
  // The end waits so long for actors to answer its Goodbye: what they have not read then is lost.
  std::chrono::milliseconds goodbye_patience{2000};
  // An actor that had more games rejected in one session is refused. Games that were true under
  // earlier settings of the run do not count.
  std::uint64_t max_rejected_games = 16;
  // While no new games are wanted, tickets held for so long (at most twice) are granted to others
  // too: an actor that hangs must not hold up the run. As long as some are wanted nobody is idle,
  // and a slow actor has all the time it needs, unless they are wanted at all times.
  std::chrono::milliseconds overdue_after{600'000};
  bool games_always_wanted = false;
  // How many games may be in play, besides the durable ones. Actors share them by their loops; at 0
  // only tickets of lost games are handed out. Asked often and on the io thread.
  std::function<std::uint64_t()> games_wanted = [] { return kAllGames; };
  // No new tickets for an actor that does not play with the newest weights yet.
  bool newest_weights_only = false;
  // The past version that the game of the next ticket meets; not set where nobody plays by past
  // weights. Called on the io thread.
  std::function<std::uint32_t()> draw_past;
  // Past versions that actors ask for: from where, and how many stay in memory.
  LoadWeights load_weights;
  std::size_t weights_kept = 8;
  std::uint32_t newest_version = 0;  // of weights that were published by earlier starts
};

struct ActorStatistics {
  std::string name;
  Heartbeat heartbeat;                   // its last one
  std::chrono::milliseconds silence{0};  // since its last message
  std::size_t tickets = 0;               // held
  std::uint64_t games = 0;               // durable, in this session
  std::uint64_t rejected = 0;            // in this session
};

// Since the start of the server.
struct IntakeStatistics : GameCounters {
  std::vector<ActorStatistics> actors;  // by name
  std::uint64_t malformed = 0;          // messages that could not be read
  std::uint64_t sessions_lost = 0;      // ended by silence
  std::uint64_t tickets_issued = 0;
  std::uint64_t first_open_ticket = 0;  // all games below are durable
};

// Moves messages between the channel and the desks that know the answers. Owns the io thread, which
// the channel, the sessions and the desks belong to, and the pipeline from construction to Stop.
// Public methods are thread-safe except Stop.
class SessionServer {
 public:
  // Durable from earlier are all tickets below `first_open` and `known`. Throws Error if the
  // settings name an unknown environment or policy.
  SessionServer(SessionServerSettings settings, std::unique_ptr<ServerChannel> channel,
                AppendGames append, std::span<const std::uint64_t> known = {},
                std::uint64_t first_open = 0);
  // Stops if nobody did; an Error is logged.
  ~SessionServer();
  SessionServer(const SessionServer&) = delete;
  SessionServer& operator=(const SessionServer&) = delete;

  // Offers these weights to every actor, now and later; versions ascend. Null: there are none yet,
  // actors play by the uniform evaluator. Before the first call actors wait. Throws Error if the
  // weights are too large for the wire.
  void Publish(const Snapshot& snapshot);

  // At most a tenth of a heartbeat old.
  [[nodiscard]] IntakeStatistics statistics() const;

  // Whether a thread ended by an Error: Stop rethrows it.
  [[nodiscard]] bool failed() const;

  // Takes no more games, makes durable what was received, acknowledges it, says `goodbye` to every
  // actor, waits until they have read it (for goodbye_patience at most) and joins. Rethrows the
  // first Error of a thread.
  void Stop(const Goodbye& goodbye);

  // Where actors on this machine connect to.
  [[nodiscard]] const std::string& endpoint() const { return endpoint_; }

 private:
  using Clock = std::chrono::steady_clock;

  // All on the io thread.
  void RunIo(const std::stop_token& stop);
  void ReceiveSome();
  void Handle(Incoming& incoming);
  void HandleFrom(Session& session, WireMessage& message);
  void OpenSession(const Incoming& incoming, const Hello& hello);
  [[nodiscard]] std::optional<Refused> Objection(const Hello& hello,
                                                 const std::string& key_owner) const;
  void ReplaceNamesake(const Hello& hello);
  void TakeGames(Session& session, Games& games);
  void TakeRequest(Session& session, const WeightsRequest& request);
  [[nodiscard]] std::uint64_t NextReceipt();
  // Some of those that wait: games are not to wait for weights.
  void AnswerRequests();
  void HandleVerdicts();
  // With new tickets, in as many messages as it takes.
  void SendAck(SessionId id, Ack ack);
  void Tick(Clock::time_point now);
  [[nodiscard]] std::chrono::milliseconds TickInterval() const;
  void EndSilentSessions(Clock::time_point now);
  void TakeLeave();
  void UpdateStatistics(Clock::time_point now);
  [[nodiscard]] bool Full() const;
  // Ends the session if the peer does not take the message.
  void Send(SessionId id, const WireMessage& message);
  void Sent(SessionId id, bool taken);
  void SendToAll(const WireMessage& message);
  // Ends the session, if there is one, and says why.
  void Refuse(const PeerId& peer, const Refused& refused);
  void EndSession(const Session& session);

  const SessionServerSettings settings_;
  const Sha256Digest settings_digest_;
  const Waker waker_;

  // The io thread's.
  std::unique_ptr<ServerChannel> channel_;
  PeerTable peers_;
  TicketOffice office_;
  TicketDesk tickets_;
  WeightsDesk weights_;
  std::deque<std::pair<SessionId, WeightsRequest>> requests_;  // one of a session at most
  const std::uint64_t receipt_secret_ = UniqueNumber();
  std::uint64_t receipts_ = 0;
  std::uint64_t malformed_ = 0;
  std::uint64_t sessions_lost_ = 0;
  log::Budget log_budget_;
  Clock::time_point last_tick_;
  Clock::time_point caught_up_ = Clock::now();  // when there was nothing left to receive

  mutable std::mutex mutex_;  // guards these
  IntakeStatistics statistics_;
  Goodbye goodbye_;

  std::atomic<bool> stopping_ = false;
  std::string endpoint_;
  GamePipeline pipeline_;
  GameDesk games_;
  std::unique_ptr<Worker> io_;
};

}  // namespace powderkeg

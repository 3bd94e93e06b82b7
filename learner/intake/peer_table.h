#pragma once

// Who is connected to the learner.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/wire/messages.h"
#include "common/wire/transport.h"
#include "learner/intake/ticket_office.h"

namespace powderkeg {

// One actor's session: from its Hello to its end.
struct Session {
  using Clock = std::chrono::steady_clock;

  SessionId id = 0;
  PeerId peer;
  Hello hello;                                      // without its tickets
  std::chrono::milliseconds heartbeat_interval{0};  // as its Welcome said
  std::chrono::milliseconds dead_after{0};
  Clock::time_point last_heard;
  Clock::time_point last_sent;
  Heartbeat heartbeat;         // its last one
  std::uint64_t games = 0;     // durable
  std::uint64_t rejected = 0;  // games of which it should have known better
  std::size_t pending = 0;     // games in the pipeline
  std::uint64_t receipt = 0;   // that it gives for the last chunk of weights once it has read that
};

// Sessions by number, by connection and by name. Pointers are good until the session is closed. One
// thread.
class PeerTable {
 public:
  // Requires that neither the connection nor the name has a session.
  Session& Open(const PeerId& peer, const Hello& hello);
  void Close(SessionId id);

  // Null: there is none.
  [[nodiscard]] Session* Find(SessionId id);
  [[nodiscard]] Session* FindPeer(const PeerId& peer);
  [[nodiscard]] Session* FindName(const std::string& name);

  [[nodiscard]] std::vector<SessionId> Ids() const;
  [[nodiscard]] const std::unordered_map<SessionId, Session>& sessions() const { return sessions_; }
  [[nodiscard]] std::size_t size() const { return sessions_.size(); }

 private:
  std::unordered_map<SessionId, Session> sessions_;
  std::unordered_map<PeerId, SessionId> by_peer_;
  std::unordered_map<std::string, SessionId> by_name_;
  SessionId last_ = 0;
};

}  // namespace powderkeg

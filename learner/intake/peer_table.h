#pragma once

// Who is connected to the learner.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
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
  Hello hello;  // without its tickets
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
  // Requires that the connection has no session.
  Session& Open(const PeerId& peer, const Hello& hello);
  void Close(SessionId id);

  // Null: there is none.
  [[nodiscard]] Session* Find(SessionId id);
  [[nodiscard]] Session* FindPeer(const PeerId& peer);
  [[nodiscard]] Session* FindName(const std::string& name);

  // Ascending.
  [[nodiscard]] std::vector<SessionId> Ids() const;
  [[nodiscard]] const std::map<SessionId, Session>& sessions() const { return sessions_; }
  [[nodiscard]] std::size_t size() const { return sessions_.size(); }

 private:
  std::map<SessionId, Session> sessions_;
  std::map<PeerId, SessionId> by_peer_;
  SessionId last_ = 0;
};

}  // namespace powderkeg

#include "learner/intake/peer_table.h"

#include "common/base/check.h"

namespace powderkeg {

Session& PeerTable::Open(const PeerId& peer, const Hello& hello) {
  const SessionId id = ++last_;
  CHECK(by_peer_.emplace(peer, id).second);
  CHECK(by_name_.emplace(hello.name, id).second);
  Session& session = sessions_[id];
  session.id = id;
  session.peer = peer;
  session.hello = hello;
  session.hello.tickets = {};
  session.last_heard = session.last_sent = Session::Clock::now();
  return session;
}

void PeerTable::Close(SessionId id) {
  const auto session = sessions_.find(id);
  by_peer_.erase(session->second.peer);
  by_name_.erase(session->second.hello.name);
  sessions_.erase(session);
}

Session* PeerTable::Find(SessionId id) {
  const auto session = sessions_.find(id);
  return session == sessions_.end() ? nullptr : &session->second;
}

Session* PeerTable::FindPeer(const PeerId& peer) {
  const auto id = by_peer_.find(peer);
  return id == by_peer_.end() ? nullptr : Find(id->second);
}

Session* PeerTable::FindName(const std::string& name) {
  const auto id = by_name_.find(name);
  return id == by_name_.end() ? nullptr : Find(id->second);
}

std::vector<SessionId> PeerTable::Ids() const {
  std::vector<SessionId> ids;
  for (const auto& [id, session] : sessions_) ids.push_back(id);
  return ids;
}

}  // namespace powderkeg

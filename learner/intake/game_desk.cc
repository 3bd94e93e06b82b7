#include "learner/intake/game_desk.h"

#include <utility>

#include "common/base/log.h"

namespace powderkeg {

bool GameDesk::Admit(Session& session, SealedGame game, Ack& ack) {
  using Standing = TicketOffice::Standing;
  switch (office_.StandingOf(game.ticket)) {
    case Standing::kDurable:
      ++counters_.duplicates;
      tickets_.Excuse(session.id);
      ack.durable.push_back(game.ticket);
      return true;
    case Standing::kNeverIssued:
      ++counters_.rejected;
      ack.rejected.push_back({.ticket = game.ticket, .reason = "the ticket was never issued"});
      return true;
    case Standing::kAwaited: break;
  }
  const std::size_t bytes = game.record.size();
  if (session.pending >= kMostTickets || !pipeline_.Submit(session.id, std::move(game))) {
    return false;
  }
  ++session.pending;
  ++counters_.pending_games;
  counters_.pending_bytes += bytes;
  return true;
}

std::map<SessionId, Ack> GameDesk::Settle() {
  std::map<SessionId, Ack> acks;
  for (const Verdict& verdict : pipeline_.TakeVerdicts()) {
    Settle(verdict);
    // One that left meanwhile will ask again.
    if (Session* session = peers_.Find(verdict.session)) {
      Answer(*session, verdict, acks[session->id]);
    }
  }
  return acks;
}

void GameDesk::Settle(const Verdict& verdict) {
  --counters_.pending_games;
  counters_.pending_bytes -= verdict.bytes;
  switch (verdict.kind) {
    case Verdict::Kind::kRejected:
      ++counters_.rejected;
      office_.Reject(verdict.session, verdict.ticket);
      return;
    case Verdict::Kind::kDuplicate: ++counters_.duplicates; break;
    case Verdict::Kind::kDurable:
      ++counters_.games;
      counters_.decisions += verdict.decisions;
      counters_.other_settings += verdict.other_settings ? 1 : 0;
      break;
  }
  office_.Complete(verdict.ticket);
}

void GameDesk::Answer(Session& session, const Verdict& verdict, Ack& ack) {
  --session.pending;
  if (verdict.kind != Verdict::Kind::kRejected) {
    ++session.games;
    if (verdict.kind == Verdict::Kind::kDurable) tickets_.Delivered(session.id);
    tickets_.Excuse(session.id);
    ack.durable.push_back(verdict.ticket);
    return;
  }
  if (!verdict.outdated) ++session.rejected;
  ack.rejected.push_back({.ticket = verdict.ticket, .reason = verdict.reason});
  if (!log_budget_.Spend()) return;
  log::Warn("rejected a game", "actor", session.hello.name, "ticket", verdict.ticket, "reason",
            verdict.reason);
}

}  // namespace powderkeg

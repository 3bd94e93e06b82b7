#include "learner/intake/ticket_office.h"

#include <algorithm>

#include "common/base/check.h"

namespace powderkeg {

TicketOffice::TicketOffice(std::span<const std::uint64_t> known, std::uint64_t first_open)
    : durable_(first_open) {
  for (const std::uint64_t ticket : known) durable_.Insert(ticket);
  issued_ = durable_.end();
  claim_limit_ = issued_ + kMaxLead;
  const std::uint64_t first_missing = durable_.first_open();
  if (issued_ - first_missing > known.size() + kMaxMissing) {
    throw Error(StrCat("the store holds the game of ticket ", issued_ - 1, ", but of the ",
                       issued_ - first_missing, " from ", first_missing, " on at most ",
                       known.size(), "; expected at most ", kMaxMissing,
                       " missing ones: is a segment damaged?"));
  }
  for (std::uint64_t ticket = durable_.first_open(); ticket < issued_; ++ticket) {
    if (!durable_.Contains(ticket)) open_.insert(ticket);
  }
}

std::vector<std::uint64_t> TicketOffice::Grant(SessionId session, std::size_t count,
                                               std::size_t count_with_new) {
  std::vector<std::uint64_t> tickets;
  tickets.reserve(count);
  while (tickets.size() < count && !open_.empty()) {
    tickets.push_back(*open_.begin());
    open_.erase(open_.begin());
  }
  while (tickets.size() < std::min(count, count_with_new)) {
    const std::uint64_t ticket = issued_++;
    if (!holders_.contains(ticket) && !durable_.Contains(ticket)) tickets.push_back(ticket);
  }
  for (const std::uint64_t ticket : tickets) Hold(session, ticket);
  return tickets;
}

void TicketOffice::Claim(SessionId session, std::span<const std::uint64_t> tickets) {
  for (const std::uint64_t ticket : tickets) {
    const bool earlier = ticket >= issued_ && ticket < claim_limit_ && !holders_.contains(ticket) &&
                         !durable_.Contains(ticket);
    if (open_.erase(ticket) != 0 || earlier) Hold(session, ticket);
  }
}

TicketOffice::Standing TicketOffice::StandingOf(std::uint64_t ticket) const {
  if (durable_.Contains(ticket)) return Standing::kDurable;
  const bool issued = ticket < issued_ || holders_.contains(ticket);
  return issued ? Standing::kAwaited : Standing::kNeverIssued;
}

void TicketOffice::Complete(std::uint64_t ticket) {
  LetGo(ticket);
  open_.erase(ticket);
  durable_.Insert(ticket);
}

void TicketOffice::Reject(SessionId session, std::uint64_t ticket) {
  const auto holder = holders_.find(ticket);
  if (holder == holders_.end() || holder->second.session != session) return;
  LetGo(ticket);
  Reopen(ticket);
}

std::map<SessionId, std::size_t> TicketOffice::TakeBackOverdue() {
  std::map<SessionId, std::size_t> taken;
  std::vector<std::uint64_t> overdue;
  for (const auto& [ticket, holder] : holders_) {
    if (holder.period == period_ || ticket >= issued_) continue;
    overdue.push_back(ticket);
    ++taken[holder.session];
  }
  for (const std::uint64_t ticket : overdue) {
    LetGo(ticket);
    open_.insert(ticket);
  }
  ++period_;
  return taken;
}

void TicketOffice::Release(SessionId session) {
  const auto found = sessions_.find(session);
  if (found == sessions_.end()) return;
  for (const std::uint64_t ticket : found->second) {
    holders_.erase(ticket);
    Reopen(ticket);
  }
  sessions_.erase(found);
}

std::size_t TicketOffice::held(SessionId session) const {
  const auto found = sessions_.find(session);
  return found == sessions_.end() ? 0 : found->second.size();
}

void TicketOffice::Hold(SessionId session, std::uint64_t ticket) {
  holders_[ticket] = {session, period_};
  sessions_[session].insert(ticket);
}

void TicketOffice::Reopen(std::uint64_t ticket) {
  if (ticket < issued_) open_.insert(ticket);
}

void TicketOffice::LetGo(std::uint64_t ticket) {
  const auto holder = holders_.find(ticket);
  if (holder == holders_.end()) return;
  const auto session = sessions_.find(holder->second.session);
  session->second.erase(ticket);
  if (session->second.empty()) sessions_.erase(session);
  holders_.erase(holder);
}

}  // namespace powderkeg

#pragma once

// Who plays which game: the tickets of a run (proto/wire.proto explains them).

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/record/ticket_set.h"

namespace powderkeg {

using SessionId = std::uint64_t;

// Grants tickets, lowest first, and takes back those of sessions that ended. A ticket is in exactly
// one state: never issued; held by one session; open (issued, held by nobody); durable. One that
// was only claimed is as if never issued once it is let go. Pure logic, one thread.
class TicketOffice {
 public:
  // Durable are, from earlier starts of the learner, all tickets below `first_open` and `known`.
  // Throws Error if more than kMaxMissing lie between those: no run has so many games in play.
  explicit TicketOffice(std::span<const std::uint64_t> known, std::uint64_t first_open = 0);

  // At most `count` tickets for a session, ascending: open ones first, then new ones, but of these
  // only as many as make `count_with_new` in all.
  [[nodiscard]] std::vector<std::uint64_t> Grant(SessionId session, std::size_t count,
                                                 std::size_t count_with_new);

  // A session returns with tickets it was granted earlier, perhaps before a restart of the
  // learner. It gets those that are open, and of those that were not issued since the start what
  // may have been issued before: less than kMaxLead beyond what was durable then. The tickets below
  // them are not open for that.
  void Claim(SessionId session, std::span<const std::uint64_t> tickets);
  static constexpr std::uint64_t kMaxLead = 1u << 16;
  static constexpr std::uint64_t kMaxMissing = 1u << 25;

  enum class Standing : std::uint8_t { kNeverIssued, kAwaited, kDurable };
  [[nodiscard]] Standing StandingOf(std::uint64_t ticket) const;

  // The game of a ticket is durable, whoever held the ticket.
  void Complete(std::uint64_t ticket);
  // The game was refused: if this session holds the ticket, it becomes open.
  void Reject(SessionId session, std::uint64_t ticket);
  // Every issued ticket held since before the last call becomes open; says how many by session. Its
  // holder may still send the game.
  [[nodiscard]] std::map<SessionId, std::size_t> TakeBackOverdue();
  // The session ended: its tickets become open.
  void Release(SessionId session);

  // Tickets that a session holds.
  [[nodiscard]] std::size_t held(SessionId session) const;
  // All tickets below were issued, and beyond it only some of earlier starts.
  [[nodiscard]] std::uint64_t issued() const { return issued_; }
  // All tickets below are durable.
  [[nodiscard]] std::uint64_t first_open() const { return durable_.first_open(); }

 private:
  void Hold(SessionId session, std::uint64_t ticket);
  void LetGo(std::uint64_t ticket);
  // Nobody holds it any more: others may.
  void Reopen(std::uint64_t ticket);

  struct Holder {
    SessionId session;
    std::uint64_t period;  // when it was granted
  };

  TicketSet durable_;
  std::uint64_t issued_;
  std::uint64_t claim_limit_;  // one more than the highest ticket that may be claimed
  std::uint64_t period_ = 0;   // between two calls of TakeBackOverdue
  std::set<std::uint64_t> open_;
  std::unordered_map<std::uint64_t, Holder> holders_;
  std::unordered_map<SessionId, std::set<std::uint64_t>> sessions_;
};

}  // namespace powderkeg

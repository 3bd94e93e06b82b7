#pragma once

// How many tickets whom: shares out the games that are wanted among the sessions.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/wire/messages.h"
#include "learner/intake/ticket_office.h"

namespace powderkeg {

inline constexpr std::uint64_t kAllGames = std::numeric_limits<std::uint64_t>::max();
inline constexpr std::size_t kMostTickets = kMaxTickets / 2;  // that a session may hold

// How many tickets an actor is to hold: every game it plays at once and a quarter more, so that
// slots stay busy while games wait for their acknowledgement.
[[nodiscard]] std::size_t TicketTarget(std::uint32_t loops, int games_in_flight);

struct TicketDeskSettings {
  int games_in_flight = 1;  // of a loop
  std::chrono::milliseconds overdue_after{0};
  bool patient = true;  // tickets are overdue only while no new games are wanted
  std::function<std::uint64_t()> games_wanted;
};

// What an actor may hold grows with the games it has delivered, from what one loop needs to what
// all its loops need: nobody gets much by a claim. Sessions share the games that are wanted by what
// they may hold. One thread.
class TicketDesk {
 public:
  using Clock = std::chrono::steady_clock;

  // `office` must outlive it.
  TicketDesk(TicketDeskSettings settings, TicketOffice& office);

  // The session claims `tickets`: of these as many count as its loops can have in play.
  void Open(SessionId session, std::uint32_t loops, std::span<const std::uint64_t> tickets);
  // Its tickets become open.
  void Close(SessionId session);

  // Tickets up to the session's share, ascending.
  [[nodiscard]] std::vector<std::uint64_t> TopUp(SessionId session);
  // A game of the session is durable.
  void Delivered(SessionId session);
  // A game has come from the session: it is not overdue, whatever was said of it.
  void Excuse(SessionId session) { accounts_.at(session).overdue = false; }
  // To be called now and then: tickets held for overdue_after (at most twice) become open, where
  // the desk is patient only while no new games are wanted; says how many by session. Those
  // sessions get no tickets until they are excused.
  [[nodiscard]] std::map<SessionId, std::size_t> TakeBackOverdue(Clock::time_point now);

 private:
  struct Account {
    std::uint32_t loops = 1;
    std::uint64_t delivered = 0;
    bool overdue = false;
  };

  [[nodiscard]] std::size_t TargetOf(const Account& account) const;
  [[nodiscard]] std::size_t ShareOf(const Account& account) const;

  const TicketDeskSettings settings_;
  TicketOffice& office_;
  std::unordered_map<SessionId, Account> accounts_;
  std::size_t targets_ = 0;                        // of all accounts together
  Clock::time_point last_overdue_ = Clock::now();  // tickets looked for
};

}  // namespace powderkeg

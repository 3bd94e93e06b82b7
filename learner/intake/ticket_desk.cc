#include "learner/intake/ticket_desk.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace powderkeg {
namespace {

constexpr std::uint64_t kEarned = 4;  // more tickets for each game delivered

}  // namespace

std::size_t TicketTarget(std::uint32_t loops, int games_in_flight) {
  const std::size_t playing = std::size_t{loops} * static_cast<std::size_t>(games_in_flight);
  return std::min(playing + std::max<std::size_t>(4, playing / 4), kMostTickets);
}

TicketDesk::TicketDesk(TicketDeskSettings settings, TicketOffice& office)
    : settings_(std::move(settings)), office_(office) {}

void TicketDesk::Open(SessionId session, std::uint32_t loops,
                      std::span<const std::uint64_t> tickets) {
  const Account& account = accounts_[session] = {.loops = loops};
  targets_ += TargetOf(account);
  const std::size_t most = TicketTarget(loops, settings_.games_in_flight);
  office_.Claim(session, tickets.first(std::min(tickets.size(), most)));
}

void TicketDesk::Close(SessionId session) {
  office_.Release(session);
  const auto account = accounts_.find(session);
  targets_ -= TargetOf(account->second);
  accounts_.erase(account);
}

void TicketDesk::Delivered(SessionId session) {
  Account& account = accounts_.at(session);
  targets_ -= TargetOf(account);
  ++account.delivered;
  targets_ += TargetOf(account);
}

std::vector<std::uint64_t> TicketDesk::TopUp(SessionId session) {
  const Account& account = accounts_.at(session);
  const std::size_t target = TargetOf(account);
  const std::size_t held = office_.held(session);
  if (held >= target || account.overdue) return {};
  const std::size_t share = std::max(held, ShareOf(account));
  return office_.Grant(session, target - held, share - held);
}

std::map<SessionId, std::size_t> TicketDesk::TakeBackOverdue(Clock::time_point now) {
  if (now - last_overdue_ < settings_.overdue_after) return {};
  last_overdue_ = now;
  if (settings_.patient && settings_.games_wanted() > 0) return {};
  auto taken = office_.TakeBackOverdue();
  for (const auto& [session, tickets] : taken) accounts_.at(session).overdue = true;
  return taken;
}

std::size_t TicketDesk::TargetOf(const Account& account) const {
  const std::size_t earned = TicketTarget(1, settings_.games_in_flight) +
                             kEarned * std::min<std::uint64_t>(account.delivered, kMostTickets);
  return std::min(earned, TicketTarget(account.loops, settings_.games_in_flight));
}

// The games that a session may have in play of all that are wanted, rounded up: where actors could
// play more than that, all of them play fewer games at once.
std::size_t TicketDesk::ShareOf(const Account& account) const {
  const std::uint64_t wanted = settings_.games_wanted();
  if (wanted == kAllGames) return kMostTickets;
  const double share = static_cast<double>(wanted) * static_cast<double>(TargetOf(account)) /
                       static_cast<double>(targets_);
  return static_cast<std::size_t>(std::min<double>(std::ceil(share), kMostTickets));
}

}  // namespace powderkeg

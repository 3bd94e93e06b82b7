#include "actors/selfplay/ticket_book.h"

#include <algorithm>

#include "common/base/check.h"

namespace powderkeg {

void TicketBook::Grant(std::span<const std::uint64_t> tickets) {
  {
    const std::lock_guard lock(mutex_);
    for (const std::uint64_t ticket : tickets) {
      if (waiting_by_ticket_.emplace(ticket, true).second) ++waiting_;
    }
  }
  changed_.notify_all();
}

void TicketBook::GrantPlayed(std::span<const std::uint64_t> tickets) {
  const std::lock_guard lock(mutex_);
  for (const std::uint64_t ticket : tickets) waiting_by_ticket_.emplace(ticket, false);
}

std::optional<std::uint64_t> TicketBook::Take() {
  const std::lock_guard lock(mutex_);
  if (waiting_ == 0) return std::nullopt;
  const auto lowest = std::find_if(waiting_by_ticket_.begin(), waiting_by_ticket_.end(),
                                   [](const auto& entry) { return entry.second; });
  CHECK(lowest != waiting_by_ticket_.end());
  lowest->second = false;
  --waiting_;
  return lowest->first;
}

void TicketBook::DropWaiting() {
  const std::lock_guard lock(mutex_);
  std::erase_if(waiting_by_ticket_, [](const auto& entry) { return entry.second; });
  waiting_ = 0;
}

void TicketBook::PutBack(std::uint64_t ticket) {
  {
    const std::lock_guard lock(mutex_);
    const auto entry = waiting_by_ticket_.find(ticket);
    if (entry == waiting_by_ticket_.end() || entry->second) return;  // settled meanwhile
    entry->second = true;
    ++waiting_;
  }
  changed_.notify_all();
}

void TicketBook::Settle(std::uint64_t ticket) {
  const std::lock_guard lock(mutex_);
  const auto entry = waiting_by_ticket_.find(ticket);
  if (entry == waiting_by_ticket_.end()) return;
  if (entry->second) --waiting_;
  waiting_by_ticket_.erase(entry);
}

void TicketBook::WaitForTicket(std::chrono::milliseconds timeout) const {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout, [&] { return waiting_ > 0; });
}

std::vector<std::uint64_t> TicketBook::Held() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::uint64_t> tickets;
  for (const auto& [ticket, waits] : waiting_by_ticket_) tickets.push_back(ticket);
  return tickets;
}

std::vector<std::uint64_t> TicketBook::Started() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::uint64_t> tickets;
  for (const auto& [ticket, waits] : waiting_by_ticket_) {
    if (!waits) tickets.push_back(ticket);
  }
  return tickets;
}

std::size_t TicketBook::waiting() const {
  const std::lock_guard lock(mutex_);
  return waiting_;
}

}  // namespace powderkeg

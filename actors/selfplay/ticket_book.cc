#include "actors/selfplay/ticket_book.h"

#include <algorithm>

#include "common/base/check.h"

namespace powderkeg {

void TicketBook::Grant(std::span<const std::uint64_t> tickets,
                       std::span<const std::uint32_t> past_versions) {
  {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < tickets.size(); ++i) {
      const std::uint32_t past = i < past_versions.size() ? past_versions[i] : 0;
      if (entries_.emplace(tickets[i], Entry{.waits = true, .past_version = past}).second) {
        ++waiting_;
      }
    }
  }
  changed_.notify_all();
}

void TicketBook::GrantPlayed(std::span<const std::uint64_t> tickets) {
  const std::lock_guard lock(mutex_);
  for (const std::uint64_t ticket : tickets) entries_.emplace(ticket, Entry{});
}

std::optional<Grant> TicketBook::Take() {
  const std::lock_guard lock(mutex_);
  if (waiting_ == 0) return std::nullopt;
  const auto lowest =
      std::ranges::find_if(entries_, [](const auto& entry) { return entry.second.waits; });
  CHECK(lowest != entries_.end());
  lowest->second.waits = false;
  --waiting_;
  return powderkeg::Grant{.ticket = lowest->first, .past_version = lowest->second.past_version};
}

void TicketBook::DropWaiting() {
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [](const auto& entry) { return entry.second.waits; });
  waiting_ = 0;
}

void TicketBook::PutBack(std::uint64_t ticket) {
  {
    const std::lock_guard lock(mutex_);
    const auto entry = entries_.find(ticket);
    if (entry == entries_.end() || entry->second.waits) return;  // settled meanwhile
    entry->second.waits = true;
    ++waiting_;
  }
  changed_.notify_all();
}

void TicketBook::Settle(std::uint64_t ticket) {
  const std::lock_guard lock(mutex_);
  const auto entry = entries_.find(ticket);
  if (entry == entries_.end()) return;
  if (entry->second.waits) --waiting_;
  entries_.erase(entry);
}

void TicketBook::WaitForTicket(std::chrono::milliseconds timeout) const {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout, [&] { return waiting_ > 0; });
}

std::vector<std::uint64_t> TicketBook::Held() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::uint64_t> tickets;
  for (const auto& [ticket, entry] : entries_) tickets.push_back(ticket);
  return tickets;
}

std::vector<std::uint64_t> TicketBook::Started() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::uint64_t> tickets;
  for (const auto& [ticket, entry] : entries_) {
    if (!entry.waits) tickets.push_back(ticket);
  }
  return tickets;
}

std::size_t TicketBook::waiting() const {
  const std::lock_guard lock(mutex_);
  return waiting_;
}

}  // namespace powderkeg

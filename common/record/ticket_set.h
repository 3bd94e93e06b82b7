#pragma once

// Which games there are.

#include <cstdint>
#include <set>
#include <string>
#include <vector>

namespace powderkeg {

// A set of tickets that is mostly a prefix 0, 1, ... of all: small however many games there were.
// One thread.
class TicketSet {
 public:
  // Every ticket below `first_open` is in it.
  explicit TicketSet(std::uint64_t first_open = 0) : first_open_(first_open) {}

  // False if it was in it already.
  bool Insert(std::uint64_t ticket) {
    if (ticket < first_open_ || !beyond_.insert(ticket).second) return false;
    while (!beyond_.empty() && *beyond_.begin() == first_open_) {
      beyond_.erase(beyond_.begin());
      ++first_open_;
    }
    return true;
  }
  [[nodiscard]] bool Contains(std::uint64_t ticket) const {
    return ticket < first_open_ || beyond_.contains(ticket);
  }
  // The lowest ticket that is not in it.
  [[nodiscard]] std::uint64_t first_open() const { return first_open_; }
  // One more than the highest that is in it.
  [[nodiscard]] std::uint64_t end() const {
    return beyond_.empty() ? first_open_ : *beyond_.rbegin() + 1;
  }

 private:
  std::uint64_t first_open_;
  std::set<std::uint64_t> beyond_;  // those above first_open_
};

// "3-5 9"; "none".
[[nodiscard]] std::string TicketsText(std::vector<std::uint64_t> tickets);

}  // namespace powderkeg

#pragma once

// The tickets an actor was granted, until the learner has settled them.

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace powderkeg {

// The right to play one game.
struct Grant {
  std::uint64_t ticket = 0;
  std::uint32_t past_version = 0;  // of the weights of players of past weights; 0: the newest

  friend bool operator==(const Grant&, const Grant&) = default;
};

// A ticket waits, then is in play (or its game lies in the outbox), until it is settled.
// Thread-safe.
class TicketBook {
 public:
  // Tickets that are in it already stay as they are. `past_versions`: one for each, or none.
  void Grant(std::span<const std::uint64_t> tickets,
             std::span<const std::uint32_t> past_versions = {});
  // As Grant, for games that were played already and lie in the outbox.
  void GrantPlayed(std::span<const std::uint64_t> tickets);

  // The lowest waiting ticket; it is in play from now on. nullopt: none waits.
  [[nodiscard]] std::optional<powderkeg::Grant> Take();
  // Forgets those that wait.
  void DropWaiting();
  // A ticket in play waits again: its game was given up.
  void PutBack(std::uint64_t ticket);

  // The game is acknowledged or rejected.
  void Settle(std::uint64_t ticket);

  // Returns when a ticket waits or time is up.
  void WaitForTicket(std::chrono::milliseconds timeout) const;

  // All of them, ascending.
  [[nodiscard]] std::vector<std::uint64_t> Held() const;
  // Those that do not wait, ascending.
  [[nodiscard]] std::vector<std::uint64_t> Started() const;
  [[nodiscard]] std::size_t waiting() const;

 private:
  mutable std::mutex mutex_;  // guards what follows
  mutable std::condition_variable changed_;
  struct Entry {
    bool waits = false;
    std::uint32_t past_version = 0;
  };
  std::map<std::uint64_t, Entry> entries_;  // by ticket
  std::size_t waiting_ = 0;
};

}  // namespace powderkeg

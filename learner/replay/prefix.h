#pragma once

// Which games form the next data set: the start-order rule as pure logic.

#include <cstdint>
#include <map>
#include <optional>

namespace powderkeg {

// The games of one data set: every ticket from first to last.
struct TicketRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;  // inclusive; an empty range does not exist

  [[nodiscard]] constexpr bool Has(std::uint64_t ticket) const {
    return first <= ticket && ticket <= last;
  }
  friend bool operator==(const TicketRange&, const TicketRange&) = default;
};

// Games finish in any order but count by when they started. Tickets are handed out as 0, 1, 2, ...;
// a data set is the shortest run of tickets that follows the previous data set, has no gap and
// holds enough decisions. Early deaths therefore cannot crowd out long games: where a data set ends
// depends only on the games before that end, so by Wald's equation the expected number of wins in
// it is the win rate times the expected number of games. (Counted in the order of finishing, short
// games come first, and short games are mostly lost ones.)
//
// A value; one thread.
class TicketPrefix {
 public:
  // The data sets so far used every ticket below `next_ticket`.
  explicit TicketPrefix(std::uint64_t next_ticket = 0)
      : next_ticket_(next_ticket), first_missing_(next_ticket) {}

  // A game was finished with this many decisions (0 is allowed). False, and nothing changes, if the
  // ticket is known already or belongs to an earlier data set.
  bool Add(std::uint64_t ticket, std::uint32_t decisions);

  // Takes the next data set of at least `decisions` decisions, if its games are all there; call it
  // again for the one after. Requires decisions > 0.
  [[nodiscard]] std::optional<TicketRange> NextDataSet(std::uint64_t decisions);

  // What was added and not taken counts as games without decisions from now on.
  void PassOver();

  struct Progress {
    std::uint64_t decisions_in_prefix = 0;  // of unused games without a gap before them
    std::uint64_t decisions = 0;            // of all unused games
    std::uint64_t games = 0;                // all unused ones
    // The first ticket that is missing, if games after it have come: what the prefix waits for.
    std::optional<std::uint64_t> straggler;
  };
  [[nodiscard]] Progress progress() const;

  // The first ticket of the next data set.
  [[nodiscard]] std::uint64_t next_ticket() const { return next_ticket_; }

 private:
  void ExtendPrefix();

  std::uint64_t next_ticket_;
  std::uint64_t first_missing_;  // every ticket from next_ticket_ up to this one is there
  std::uint64_t decisions_in_prefix_ = 0;
  std::uint64_t decisions_ = 0;
  std::map<std::uint64_t, std::uint32_t> unused_;  // decisions by ticket
};

}  // namespace powderkeg

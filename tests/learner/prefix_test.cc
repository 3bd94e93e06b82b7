#include "learner/replay/prefix.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "common/base/rng.h"

namespace powderkeg {
namespace {

using Range = std::optional<TicketRange>;

TEST(TicketPrefix, WaitsUntilThePrefixHoldsEnough) {
  TicketPrefix prefix;
  EXPECT_EQ(prefix.NextDataSet(10), std::nullopt);
  EXPECT_TRUE(prefix.Add(0, 6));
  EXPECT_EQ(prefix.NextDataSet(10), std::nullopt);
  EXPECT_TRUE(prefix.Add(1, 4));
  EXPECT_EQ(prefix.NextDataSet(10), (Range{{0, 1}}));
  EXPECT_EQ(prefix.next_ticket(), 2u);
}

TEST(TicketPrefix, TakesTheShortestPrefixAndKeepsTheRest) {
  TicketPrefix prefix;
  for (std::uint64_t ticket = 0; ticket < 5; ++ticket) prefix.Add(ticket, 7);
  EXPECT_EQ(prefix.NextDataSet(14), (Range{{0, 1}}));
  EXPECT_EQ(prefix.progress().decisions_in_prefix, 21u);
  EXPECT_EQ(prefix.NextDataSet(15), (Range{{2, 4}}));
  EXPECT_EQ(prefix.progress().decisions, 0u);
}

TEST(TicketPrefix, AMissingGameHoldsTheOnesAfterIt) {
  TicketPrefix prefix;
  prefix.Add(0, 5);
  EXPECT_EQ(prefix.progress().straggler, std::nullopt);
  prefix.Add(2, 50);
  prefix.Add(3, 50);
  EXPECT_EQ(prefix.NextDataSet(10), std::nullopt);
  EXPECT_EQ(prefix.progress().decisions_in_prefix, 5u);
  EXPECT_EQ(prefix.progress().decisions, 105u);
  EXPECT_EQ(prefix.progress().games, 3u);
  EXPECT_EQ(prefix.progress().straggler, 1u);
  prefix.Add(1, 0);  // no decision, but no gap any more
  EXPECT_EQ(prefix.progress().straggler, std::nullopt);
  EXPECT_EQ(prefix.NextDataSet(10), (Range{{0, 2}}));
}

TEST(TicketPrefix, EveryTicketCountsOnce) {
  TicketPrefix prefix(/*next_ticket=*/10);
  EXPECT_FALSE(prefix.Add(9, 100)) << "used by an earlier data set";
  EXPECT_TRUE(prefix.Add(10, 5));
  EXPECT_FALSE(prefix.Add(10, 5));
  EXPECT_EQ(prefix.progress().decisions, 5u);
  EXPECT_EQ(prefix.NextDataSet(1), (Range{{10, 10}}));
  EXPECT_FALSE(prefix.Add(10, 5));
}

TEST(TicketPrefix, DataSetsPartitionTheTicketsInAnyOrderOfArrival) {
  std::vector<std::uint64_t> tickets(500);
  for (std::size_t i = 0; i < tickets.size(); ++i) tickets[i] = i;
  std::vector<TicketRange> expected;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng(seed).Shuffle(std::span(tickets));
    TicketPrefix prefix;
    std::vector<TicketRange> ranges;
    for (const std::uint64_t ticket : tickets) {
      prefix.Add(ticket, static_cast<std::uint32_t>(ticket * 7919 % 40));
      while (const Range range = prefix.NextDataSet(300)) ranges.push_back(*range);
    }
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      EXPECT_EQ(ranges[i].first, i == 0 ? 0 : ranges[i - 1].last + 1);
    }
    if (seed == 0) expected = ranges;
    EXPECT_EQ(ranges, expected);
  }
}

// ---- Bias ---------------------------------------------------------------------------------------

// Games of constant skill whose length depends on their result, as in Pommerman: half are won, and
// those take longer.
struct SimulatedGame {
  bool won;
  std::uint32_t decisions;  // one per unit of time
};

SimulatedGame GameOfTicket(std::uint64_t run, std::uint64_t ticket) {
  Rng rng = Rng(run).Split(ticket);
  const bool won = rng.Below(2) == 0;
  return {won, won ? 150 + rng.Below(300) : 20 + rng.Below(100)};
}

// Tickets in the order in which games finish when `in_flight` are always being played.
std::vector<std::uint64_t> FinishOrder(std::uint64_t run, std::size_t in_flight,
                                       std::size_t games) {
  using Running = std::pair<std::uint64_t, std::uint64_t>;  // time of the end, ticket
  std::vector<Running> running;
  std::vector<std::uint64_t> finished;
  std::uint64_t next_ticket = 0;
  const auto start = [&](std::uint64_t now) {
    running.emplace_back(now + GameOfTicket(run, next_ticket).decisions, next_ticket);
    std::ranges::push_heap(running, std::greater());
    ++next_ticket;
  };
  while (next_ticket < in_flight) start(0);
  while (finished.size() < games) {
    std::ranges::pop_heap(running, std::greater());
    const Running first = running.back();
    running.pop_back();
    finished.push_back(first.second);
    start(first.first);
  }
  return finished;
}

struct Tally {
  double wins = 0;
  double games = 0;

  void Add(const SimulatedGame& game) {
    wins += game.won ? 1 : 0;
    games += 1;
  }
  [[nodiscard]] double WinRate() const { return wins / games; }
};

constexpr std::uint32_t kDecisions = 10'000;
constexpr std::uint64_t kRuns = 300;

// Over the first data sets of many runs, as each run's actors start afresh.
Tally FirstDataSetsByPrefix(std::size_t in_flight) {
  Tally tally;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    TicketPrefix prefix;
    Range range;
    for (const std::uint64_t ticket : FinishOrder(run, in_flight, 8 * in_flight + 200)) {
      prefix.Add(ticket, GameOfTicket(run, ticket).decisions);
      if ((range = prefix.NextDataSet(kDecisions))) break;
    }
    EXPECT_TRUE(range.has_value());
    for (std::uint64_t ticket = range->first; ticket <= range->last; ++ticket) {
      tally.Add(GameOfTicket(run, ticket));
    }
  }
  return tally;
}

Tally FirstDataSetsByFinish(std::size_t in_flight) {
  Tally tally;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    std::uint32_t decisions = 0;
    for (const std::uint64_t ticket : FinishOrder(run, in_flight, 8 * in_flight + 200)) {
      if (decisions >= kDecisions) break;
      tally.Add(GameOfTicket(run, ticket));
      decisions += GameOfTicket(run, ticket).decisions;
    }
  }
  return tally;
}

// About 55 games a data set: the standard error over all runs is 0.004.
TEST(TicketPrefix, WinRateOfDataSetsIsUnbiasedWhateverTheGamesInFlight) {
  EXPECT_NEAR(FirstDataSetsByPrefix(8).WinRate(), 0.5, 0.015);
  EXPECT_NEAR(FirstDataSetsByPrefix(256).WinRate(), 0.5, 0.015);
}

TEST(TicketPrefix, CountingInTheOrderOfFinishingWouldBeBiased) {
  EXPECT_LT(FirstDataSetsByFinish(8).WinRate(), 0.48);
  EXPECT_LT(FirstDataSetsByFinish(256).WinRate(), 0.2);
}

TEST(TicketPrefix, PassedOverGamesAreThereAndCountForNothing) {
  TicketPrefix prefix;
  for (const std::uint64_t ticket : {0, 1, 3}) prefix.Add(ticket, 10);
  prefix.PassOver();
  EXPECT_EQ(prefix.progress().decisions, 0u);
  EXPECT_FALSE(prefix.NextDataSet(10));
  prefix.Add(2, 10);
  EXPECT_FALSE(prefix.Add(3, 10)) << "it is known";
  const auto range = prefix.NextDataSet(10);
  ASSERT_TRUE(range);
  EXPECT_EQ(range->last, 2u);
}

}  // namespace
}  // namespace powderkeg

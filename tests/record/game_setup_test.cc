#include "common/record/game_setup.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

namespace powderkeg {
namespace {

SelfPlayConfig League() {
  SelfPlayConfig config;
  config.players = {{.name = "me", .teaches = Teaches::kSearch},
                    {.name = "past", .weights = PlayerSpec::Weights::kPast}};
  config.lineups = {{.share = 3, .seats = {"me", "past", "simple_unbiased", "idle"}},
                    {.share = 1, .exam = true, .seats = {"me", "harmless", "harmless", "idle"}}};
  return config;
}

TEST(RunGames, EqualTicketsGiveEqualGames) {
  const RunGames games(League());
  const RunGames others(League());
  std::set<std::uint64_t> seeds;
  for (std::uint64_t ticket = 0; ticket < 200; ++ticket) {
    EXPECT_EQ(games.SetupFor(ticket), others.SetupFor(ticket));
    seeds.insert(games.SetupFor(ticket).seed);
  }
  EXPECT_EQ(seeds.size(), 200u);
}

TEST(RunGames, LineupsComeByTheirShares) {
  const RunGames games(League());
  constexpr int kGames = 4000;
  int exams = 0;
  for (std::uint64_t ticket = 0; ticket < kGames; ++ticket) {
    exams += games.lineups()[games.SetupFor(ticket).lineup].exam ? 1 : 0;
  }
  EXPECT_NEAR(exams, kGames / 4, 4 * std::sqrt(kGames * 0.25 * 0.75));
}

// Neighbours stay neighbours, so that mates stay mates.
TEST(RunGames, LineupsAreTurnedAsAWhole) {
  const RunGames games(League());
  std::map<AgentId, int> seats_of_me;
  for (std::uint64_t ticket = 0; ticket < 400; ++ticket) {
    const GameSetup setup = games.SetupFor(ticket);
    if (setup.lineup != 0) continue;
    for (AgentId seat = 0; seat < kAgentCount; ++seat) {
      if (games.players()[setup.seats[seat].player].name != "me") continue;
      ++seats_of_me[seat];
      const Seat& next = setup.seats[(seat + 1) % kAgentCount];
      EXPECT_EQ(games.players()[next.player].name, "past");
      EXPECT_TRUE(next.searches);
      const Seat& script = setup.seats[(seat + 2) % kAgentCount];
      EXPECT_FALSE(script.searches);
      EXPECT_EQ(script.policy, PolicyKind::kSimpleUnbiased);
    }
  }
  EXPECT_EQ(seats_of_me.size(), 4u);
}

TEST(RunGames, TeachersAreMeasuredAndOfAnExamTheFirstPlayer) {
  const RunGames games(League());
  for (std::uint64_t ticket = 0; ticket < 100; ++ticket) {
    const GameSetup setup = games.SetupFor(ticket);
    const bool exam = games.lineups()[setup.lineup].exam;
    for (const Seat& seat : setup.seats) {
      const bool me = games.players()[seat.player].name == "me";
      EXPECT_EQ(seat.measured, me);
      EXPECT_EQ(seat.teaches, me && !exam ? Teaches::kSearch : Teaches::kNothing);
    }
  }
}

TEST(RunGames, DemonstrationsNeedNoSearch) {
  SelfPlayConfig config;
  config.players = {{.name = "teacher", .agent = "simple_unbiased", .teaches = Teaches::kMoves}};
  config.lineups = {{.seats = {"teacher", "teacher", "teacher", "teacher"}}};
  for (const Seat& seat : RunGames(config).SetupFor(7).seats) {
    EXPECT_FALSE(seat.searches);
    EXPECT_EQ(seat.teaches, Teaches::kMoves);
    EXPECT_TRUE(seat.measured);
  }
}

TEST(RunGames, OneAgainstOneHasTwoSeats) {
  SelfPlayConfig config;
  config.environment = "OneVsOne-v0";
  config.lineups = {{.seats = {"me", "simple_unbiased"}}};
  config.players = {{.name = "me", .teaches = Teaches::kSearch}};
  std::set<AgentId> seats;
  for (std::uint64_t ticket = 0; ticket < 50; ++ticket) {
    const GameSetup setup = RunGames(config).SetupFor(ticket);
    EXPECT_FALSE(setup.seats[2].searches || setup.seats[3].searches);
    seats.insert(setup.seats[0].searches ? 0 : 1);
  }
  EXPECT_EQ(seats.size(), 2u);
}

}  // namespace
}  // namespace powderkeg

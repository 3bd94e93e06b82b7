#include "learner/intake/ticket_office.h"

#include <gtest/gtest.h>

#include <set>

#include "common/base/check.h"
#include "common/base/rng.h"

namespace powderkeg {
namespace {

using Tickets = std::vector<std::uint64_t>;
using Standing = TicketOffice::Standing;

TEST(TicketSetTest, IsAPrefixAndWhatLiesBeyond) {
  TicketSet set(2);
  EXPECT_TRUE(set.Contains(1));
  EXPECT_FALSE(set.Contains(2));
  EXPECT_TRUE(set.Insert(4));
  EXPECT_FALSE(set.Insert(4));
  EXPECT_FALSE(set.Insert(0));
  EXPECT_EQ(set.first_open(), 2u);
  EXPECT_EQ(set.end(), 5u);
  EXPECT_TRUE(set.Insert(2));
  EXPECT_TRUE(set.Insert(3));
  EXPECT_EQ(set.first_open(), 5u);
}

TEST(TicketOfficeTest, GrantsInOrder) {
  TicketOffice office({});
  EXPECT_EQ(office.Grant(1, 3, 3), (Tickets{0, 1, 2}));
  EXPECT_EQ(office.Grant(2, 2, 2), (Tickets{3, 4}));
  EXPECT_EQ(office.held(1), 3u);
  EXPECT_EQ(office.StandingOf(4), Standing::kAwaited);
  EXPECT_EQ(office.StandingOf(5), Standing::kNeverIssued);
}

// Games that the learner has used and the user has removed.
TEST(TicketOfficeTest, WhatLiesBelowTheFirstOpenTicketIsDone) {
  TicketOffice office(Tickets{102}, 100);
  EXPECT_EQ(office.StandingOf(7), Standing::kDurable);
  EXPECT_EQ(office.Grant(1, 3, 3), (Tickets{100, 101, 103}));
}

TEST(TicketOfficeTest, ReissuesLowestFirst) {
  TicketOffice office({});
  (void)office.Grant(1, 4, 4);
  (void)office.Grant(2, 1, 1);
  office.Complete(2);
  office.Release(1);
  EXPECT_EQ(office.held(1), 0u);
  EXPECT_EQ(office.Grant(3, 5, 5), (Tickets{0, 1, 3, 5, 6}));
}

TEST(TicketOfficeTest, LostTicketsAreGrantedEvenWhereNewOnesAreNot) {
  TicketOffice office(Tickets{});
  (void)office.Grant(1, 3, 3);
  EXPECT_TRUE(office.Grant(2, 2, 0).empty());
  office.Release(1);
  EXPECT_EQ(office.Grant(2, 2, 0), (Tickets{0, 1}));
  EXPECT_EQ(office.Grant(3, 4, 2), (Tickets{2, 3})) << "one lost, one new";
  EXPECT_EQ(office.issued(), 4u);
}

TEST(TicketOfficeTest, TheFirstDurableGameWins) {
  TicketOffice office({});
  (void)office.Grant(1, 2, 2);
  office.Release(1);
  (void)office.Grant(2, 2, 2);
  office.Complete(0);  // sent by the one that was thought dead
  EXPECT_EQ(office.StandingOf(0), Standing::kDurable);
  EXPECT_EQ(office.held(2), 1u);
  office.Complete(0);
  office.Release(2);
  EXPECT_EQ(office.Grant(3, 1, 1), (Tickets{1}));
}

TEST(TicketOfficeTest, OnlyTheHolderGivesARejectedTicketBack) {
  TicketOffice office({});
  (void)office.Grant(1, 1, 1);
  office.Reject(2, 0);
  EXPECT_EQ(office.held(1), 1u);
  office.Reject(1, 0);
  EXPECT_EQ(office.held(1), 0u);
  EXPECT_EQ(office.Grant(2, 1, 1), (Tickets{0}));
}

TEST(TicketOfficeTest, RestartsFromWhatIsKnown) {
  const Tickets known = {1, 2, 5};
  TicketOffice office(known);
  EXPECT_EQ(office.Grant(1, 5, 5), (Tickets{0, 3, 4, 6, 7}));
  EXPECT_EQ(office.StandingOf(5), Standing::kDurable);
  TicketOffice later(known, 10);
  EXPECT_EQ(later.Grant(1, 1, 1), (Tickets{10}));
}

TEST(TicketOfficeTest, AnAbsurdTicketInTheStoreIsAnError) {
  EXPECT_THROW(TicketOffice(Tickets{0, 1, std::uint64_t{1} << 62}), Error);
  EXPECT_THROW(TicketOffice(Tickets{TicketOffice::kMaxMissing + 2}), Error);
}

TEST(TicketOfficeTest, AReturningActorKeepsItsTickets) {
  const Tickets known = {0, 1};
  TicketOffice office(known);
  office.Claim(1, Tickets{1, 4, 7});
  EXPECT_EQ(office.held(1), 2u);  // 1 is durable
  office.Claim(2, Tickets{4});
  EXPECT_EQ(office.held(2), 0u);
  EXPECT_EQ(office.StandingOf(4), Standing::kAwaited);
  EXPECT_EQ(office.Grant(2, 6, 6), (Tickets{2, 3, 5, 6, 8, 9}));
}

// Else one Hello would switch flow control off: open tickets are granted whatever is wanted.
TEST(TicketOfficeTest, AClaimOpensNothing) {
  TicketOffice office(Tickets{0, 1});
  office.Claim(1, Tickets{TicketOffice::kMaxLead - 1});
  EXPECT_EQ(office.held(1), 1u);
  EXPECT_TRUE(office.Grant(2, 100, 0).empty());
  EXPECT_EQ(office.issued(), 2u);
  office.Release(1);
  EXPECT_TRUE(office.Grant(2, 100, 0).empty());
  EXPECT_EQ(office.StandingOf(TicketOffice::kMaxLead - 1), Standing::kNeverIssued);
}

TEST(TicketOfficeTest, AGameOfAnEarlierStartCountsBeforeItsTicketIsIssuedAnew) {
  TicketOffice office(Tickets{0, 1});
  office.Claim(1, Tickets{4});
  office.Complete(4);
  EXPECT_EQ(office.StandingOf(4), Standing::kDurable);
  EXPECT_EQ(office.Grant(1, 4, 4), (Tickets{2, 3, 5, 6}));
}

TEST(TicketOfficeTest, AbsurdClaimsAreIgnored) {
  TicketOffice office({});
  office.Claim(1, Tickets{TicketOffice::kMaxLead, ~std::uint64_t{0}});
  EXPECT_EQ(office.issued(), 0u);
  EXPECT_EQ(office.held(1), 0u);
}

// Whatever happens, every ticket is played in the end and none twice at a time.
TEST(TicketOfficeTest, HoldsUnderRandomEvents) {
  TicketOffice office({});
  Rng rng(3);
  std::map<SessionId, std::set<std::uint64_t>> held;
  for (int i = 0; i < 5000; ++i) {
    const SessionId session = rng.Below(4);
    std::set<std::uint64_t>& mine = held[session];
    switch (rng.Below(4)) {
      case 0:
        for (const std::uint64_t ticket : office.Grant(session, rng.Below(4), rng.Below(4))) {
          for (const auto& [other, tickets] : held) ASSERT_FALSE(tickets.contains(ticket));
          mine.insert(ticket);
        }
        break;
      case 1:
        if (mine.empty()) break;
        office.Complete(*mine.begin());
        mine.erase(mine.begin());
        break;
      case 2:
        if (mine.empty()) break;
        office.Reject(session, *mine.rbegin());
        mine.erase(*mine.rbegin());
        break;
      default:
        if (rng.Below(10) != 0) break;
        office.Release(session);
        mine.clear();
    }
    ASSERT_EQ(office.held(session), mine.size());
  }
  for (SessionId session = 0; session < 4; ++session) office.Release(session);
  while (office.first_open() < office.issued()) {
    for (const std::uint64_t ticket : office.Grant(9, 1, 1)) office.Complete(ticket);
  }
}

// However often somebody claims: what claims may add is bounded for good.
TEST(TicketOfficeTest, ClaimsDoNotAddUp) {
  TicketOffice office(Tickets{0, 1, 2});
  for (int i = 0; i < 3; ++i) {
    office.Claim(1, Tickets{office.issued() + TicketOffice::kMaxLead - 1});
  }
  EXPECT_LE(office.issued(), 3 + TicketOffice::kMaxLead);
}

TEST(TicketOfficeTest, OverdueTicketsGoToOthersAndTheFirstGameCounts) {
  using Overdue = std::map<SessionId, std::size_t>;
  TicketOffice office({});
  (void)office.Grant(1, 2, 2);
  EXPECT_EQ(office.TakeBackOverdue(), Overdue{}) << "they were just granted";
  (void)office.Grant(2, 1, 1);
  EXPECT_EQ(office.TakeBackOverdue(), (Overdue{{1, 2}}));
  EXPECT_EQ(office.held(1), 0u);
  EXPECT_EQ(office.Grant(3, 2, 2), (Tickets{0, 1}));
  office.Complete(0);  // sent by 1 after all
  EXPECT_EQ(office.held(3), 1u);
  EXPECT_EQ(office.TakeBackOverdue(), (Overdue{{2, 1}}));
}

}  // namespace
}  // namespace powderkeg

#include "learner/intake/ticket_desk.h"

#include <gtest/gtest.h>

namespace powderkeg {
namespace {

using Clock = TicketDesk::Clock;

constexpr auto kOverdueAfter = std::chrono::milliseconds(1000);

TicketDeskSettings Settings(std::uint64_t wanted, bool patient = true) {
  return {.games_in_flight = 8,
          .overdue_after = kOverdueAfter,
          .patient = patient,
          .games_wanted = [wanted] { return wanted; }};
}

TEST(TicketDeskTest, SessionsShareWhatIsWantedByWhatTheyMayHold) {
  TicketOffice office({});
  TicketDesk desk(Settings(/*wanted=*/30), office);
  desk.Open(1, /*loops=*/4, {});
  for (int i = 0; i < 100; ++i) desk.Delivered(1);  // it may hold what four loops need
  desk.Open(2, /*loops=*/1, {});
  desk.Open(3, /*loops=*/1, {});
  const std::size_t large = TicketTarget(4, 8);
  const std::size_t all = large + 2 * TicketTarget(1, 8);
  EXPECT_EQ(desk.TopUp(1).size(), (30 * large + all - 1) / all);
  desk.Close(2);
  const std::size_t left = all - TicketTarget(1, 8);
  EXPECT_EQ(desk.TopUp(3).size(), (30 * TicketTarget(1, 8) + left - 1) / left);
}

// While games are wanted nobody waits for a slow actor's, unless data sets take what is there
// without a gap.
TEST(TicketDeskTest, OnlyAnImpatientDeskTakesTicketsBackWhileGamesAreWanted) {
  for (const bool patient : {true, false}) {
    TicketOffice office({});
    TicketDesk desk(Settings(/*wanted=*/1000, patient), office);
    desk.Open(1, /*loops=*/1, {});
    const std::size_t held = desk.TopUp(1).size();
    const auto later = Clock::now() + 2 * kOverdueAfter;
    EXPECT_TRUE(desk.TakeBackOverdue(later).empty()) << "they were just granted";
    const auto taken = desk.TakeBackOverdue(later + kOverdueAfter);
    EXPECT_EQ(taken.size(), patient ? 0u : 1u);
    if (!patient) {
      EXPECT_EQ(taken.at(1), held);
    }
  }
}

}  // namespace
}  // namespace powderkeg

#include "learner/report/live_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace powderkeg {
namespace {

using std::chrono::seconds;
using testing::HasSubstr;
using testing::Not;

const LiveLine::Clock::time_point kStart{};

LiveStatus Waiting(std::uint64_t decisions) {
  LiveStatus status;
  status.iterations_done = 2;
  status.iterations = 40;
  status.decisions = decisions;
  status.decisions_wanted = 100'000;
  status.actors = 2;
  status.totals = {.games = decisions / 200,
                   .decisions = decisions,
                   .evaluations = 50 * decisions,
                   .batches = 2 * decisions};
  return status;
}

TEST(Grouped, SeparatesThousands) {
  EXPECT_EQ(Grouped(0), "0");
  EXPECT_EQ(Grouped(999), "999");
  EXPECT_EQ(Grouped(1'000), "1,000");
  EXPECT_EQ(Grouped(61'212'345), "61,212,345");
}

TEST(LiveLine, SaysWhatItWaitsForAndHowLongStill) {
  LiveLine live;
  (void)live.Next(Waiting(0), kStart);
  const std::string line = live.Next(Waiting(20'000), kStart + seconds(10));
  EXPECT_THAT(line, HasSubstr("iteration 3/40 [###"));
  EXPECT_THAT(line, HasSubstr("have 20,000 of 100,000 decisions, 40 s left"));
  EXPECT_THAT(line, HasSubstr("2000 decisions/s, 10.0 games/s, 100.0 k evaluations/s, batch 25.0"));
  EXPECT_THAT(line, HasSubstr("2 actors"));
}

TEST(LiveLine, LeavesOutWhatDoesNotFit) {
  const auto line = [](std::size_t width) {
    LiveLine live;
    (void)live.Next(Waiting(0), kStart);
    return live.Next(Waiting(20'000), kStart + seconds(10), width);
  };
  EXPECT_EQ(line(79),
            "iteration 3/40 [###.............] have 20,000 of 100,000 decisions, 40 s left");
  EXPECT_EQ(line(119),
            "iteration 3/40 [###.............] have 20,000 of 100,000 decisions, 40 s left | "
            "2 actors, 2000 decisions/s");
  EXPECT_EQ(line(70), "iteration 3/40 have 20,000 of 100,000 decisions, 40 s left | 2 actors");
  EXPECT_EQ(line(14), "iteration 3/40");
  for (std::size_t width = 0; width < 200; ++width) ASSERT_LE(line(width).size(), width);
}

TEST(LiveLine, SaysNoRateThatItDoesNotKnow) {
  EXPECT_EQ(LiveLine().Next(Waiting(0), kStart),
            "iteration 3/40 [................] have 0 of 100,000 decisions | 2 actors");
}

TEST(LiveLine, NamesTheStragglerOnceTheRestIsThere) {
  LiveStatus status = Waiting(20'000);
  status.straggler = 17;
  status.decisions_beyond = 10'000;
  EXPECT_THAT(LiveLine().Next(status, kStart), Not(HasSubstr("game 17")));
  status.decisions_beyond = 90'000;
  EXPECT_THAT(LiveLine().Next(status, kStart), HasSubstr("waiting for game 17"));
}

TEST(LiveLine, ShowsTheTrainingWhileItTrains) {
  LiveLine live;
  LiveStatus status = Waiting(120'000);
  status.samples_wanted = 10'000;
  (void)live.Next(status, kStart);
  status.samples = 2'500;
  EXPECT_THAT(live.Next(status, kStart + seconds(5)),
              HasSubstr("training 2,500 of 10,000 samples, 500/s, 15 s left"));
}

TEST(LiveLine, AnActorThatStartsAnewDoesNotBreakTheRates) {
  LiveLine live;
  (void)live.Next(Waiting(50'000), kStart);
  EXPECT_THAT(live.Next(Waiting(10'000), kStart + seconds(10)), HasSubstr("1000 decisions/s"));
}

}  // namespace
}  // namespace powderkeg

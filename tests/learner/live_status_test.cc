#include "learner/report/live_status.h"

#include <gtest/gtest.h>

namespace powderkeg {
namespace {

TEST(PhaseOf, SaysWhatTheRunIsAt) {
  LiveStatus status{.iterations_done = 2, .iterations = 40, .decisions_wanted = 1000};
  EXPECT_EQ(PhaseOf(status), Phase::kWaitingForActors);
  status.actors = 2;
  EXPECT_EQ(PhaseOf(status), Phase::kPlaying);
  status.straggler = 17;
  status.decisions_beyond = 999;
  EXPECT_EQ(PhaseOf(status), Phase::kPlaying) << "the straggler is not what is missing alone";
  status.decisions_beyond = 1000;
  EXPECT_EQ(PhaseOf(status), Phase::kWaitingForGame);
  status.decisions = 1000;
  EXPECT_EQ(PhaseOf(status), Phase::kPreparing);
  status.samples_wanted = 10;
  EXPECT_EQ(PhaseOf(status), Phase::kTraining);
  status.actors = 0;
  EXPECT_EQ(PhaseOf(status), Phase::kTraining) << "nobody is needed for that";
  status.iterations_done = 40;
  EXPECT_EQ(PhaseOf(status), Phase::kComplete);
}

TEST(LiveStatus, CountsTheIterationInProgress) {
  EXPECT_EQ((LiveStatus{.iterations_done = 0, .iterations = 2}.iteration()), 1);
  EXPECT_EQ((LiveStatus{.iterations_done = 1, .iterations = 2}.iteration()), 2);
  EXPECT_EQ((LiveStatus{.iterations_done = 2, .iterations = 2}.iteration()), 2);
}

}  // namespace
}  // namespace powderkeg

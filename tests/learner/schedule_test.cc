#include "learner/train/schedule.h"

#include <gtest/gtest.h>

namespace powderkeg {
namespace {

using Range = std::optional<TicketRange>;
using Use = Schedule::Use;

Schedule ThreeIterations(std::vector<TicketRange> data_sets = {}) {
  return Schedule({.iterations = 3, .decisions_per_iteration = 10, .window_data_sets = 2},
                  std::move(data_sets));
}

TEST(Schedule, RunsItsIterationsAndEnds) {
  Schedule schedule = ThreeIterations();
  for (std::uint64_t ticket = 0; ticket < 8; ++ticket) {
    EXPECT_EQ(schedule.Add(ticket, 5), Use::kNextDataSets);
  }
  EXPECT_EQ(schedule.iteration(), 0);
  EXPECT_EQ(schedule.StartIteration(), (Range{{0, 1}}));
  EXPECT_EQ(schedule.StartIteration(), (Range{{2, 3}}));
  EXPECT_FALSE(schedule.finished());
  EXPECT_EQ(schedule.StartIteration(), (Range{{4, 5}}));
  EXPECT_TRUE(schedule.finished());
  EXPECT_EQ(schedule.StartIteration(), std::nullopt);
  EXPECT_EQ(schedule.iteration(), 3);
}

TEST(Schedule, WaitsForGames) {
  Schedule schedule = ThreeIterations();
  schedule.Add(1, 50);
  EXPECT_EQ(schedule.StartIteration(), std::nullopt);
  EXPECT_EQ(schedule.iteration(), 0);
}

TEST(Schedule, GoesOnAfterARestart) {
  Schedule schedule = ThreeIterations({{0, 4}, {5, 9}});
  EXPECT_EQ(schedule.iteration(), 2);
  EXPECT_EQ(schedule.Add(4, 10), Use::kNone) << "its data set has left the window";
  EXPECT_EQ(schedule.Add(5, 10), Use::kWindow);
  EXPECT_EQ(schedule.Add(9, 10), Use::kWindow);
  EXPECT_EQ(schedule.Add(10, 10), Use::kNextDataSets);
  EXPECT_EQ(schedule.Add(10, 10), Use::kNone) << "known already";
  ASSERT_EQ(schedule.WindowOfNext().size(), 1u);
  EXPECT_EQ(schedule.WindowOfNext()[0], (TicketRange{5, 9}));
  EXPECT_EQ(schedule.StartIteration(), (Range{{10, 10}}));
  EXPECT_TRUE(schedule.finished());
}

// Whatever the user has removed of the games below.
TEST(Schedule, WhatACheckpointHasUsedIsDone) {
  EXPECT_EQ(ThreeIterations().next_ticket(), 0u);
  EXPECT_EQ(ThreeIterations({{0, 4}, {5, 9}}).next_ticket(), 10u);
}

// The window of two data sets after an iteration begins with that iteration's own.
TEST(Schedule, KnowsWhatARestartMayNeed) {
  const Schedule schedule = ThreeIterations({{0, 4}, {5, 9}, {10, 14}});
  EXPECT_EQ(schedule.OldestTicketNeeded(/*checkpoints=*/1), 10u);
  EXPECT_EQ(schedule.OldestTicketNeeded(/*checkpoints=*/2), 5u);
  EXPECT_EQ(schedule.OldestTicketNeeded(/*checkpoints=*/3), 0u);
  EXPECT_EQ(schedule.OldestTicketNeeded(/*checkpoints=*/9), 0u);
  const Schedule no_window({.iterations = 3, .decisions_per_iteration = 10}, {{0, 4}, {5, 9}});
  EXPECT_EQ(no_window.OldestTicketNeeded(1), 10u);
  EXPECT_EQ(no_window.OldestTicketNeeded(2), 5u);
}

TEST(Schedule, WantsGamesForTwoDataSetsByTheirMeanLength) {
  Schedule schedule({.iterations = 4, .decisions_per_iteration = 1000, .window_data_sets = 2});
  EXPECT_EQ(schedule.GamesWanted(), 10u) << "of a usual length";
  schedule.Add(0, 100);
  EXPECT_EQ(schedule.GamesWanted(), 19u);
  schedule.Add(2, 300);
  EXPECT_EQ(schedule.GamesWanted(), 8u) << "games behind a gap count too";
  for (std::uint64_t ticket : {1, 3, 4, 5}) schedule.Add(ticket, 400);
  EXPECT_EQ(schedule.GamesWanted(), 0u);
  ASSERT_TRUE(schedule.StartIteration());
  EXPECT_GT(schedule.GamesWanted(), 0u);
}

TEST(Schedule, KnowsTheIterationOfATicket) {
  const Schedule schedule = ThreeIterations({{0, 4}, {5, 9}});
  EXPECT_EQ(schedule.IterationOf(0), 1);
  EXPECT_EQ(schedule.IterationOf(9), 2);
  EXPECT_EQ(schedule.IterationOf(10), 3);
  EXPECT_EQ(schedule.IterationOf(1000), 3) << "of the next one, as far as is known";
}

TEST(Schedule, CanKeepFromPlayingAhead) {
  Schedule schedule({.iterations = 4,
                     .decisions_per_iteration = 1000,
                     .window_data_sets = 2,
                     .data_sets_ahead = 1});
  EXPECT_EQ(schedule.GamesWanted(), 5u);
  schedule.Add(0, 1000);
  EXPECT_EQ(schedule.GamesWanted(), 0u);
}

TEST(Schedule, WantsNoGamesThatNoIterationWouldUse) {
  Schedule schedule({.iterations = 2, .decisions_per_iteration = 100});
  schedule.Add(0, 100);
  EXPECT_EQ(schedule.GamesWanted(), 1u);
  ASSERT_TRUE(schedule.StartIteration());
  EXPECT_EQ(schedule.GamesWanted(), 1u) << "one iteration is left";
  schedule.Add(1, 100);
  EXPECT_EQ(schedule.GamesWanted(), 0u);
  ASSERT_TRUE(schedule.StartIteration());
  EXPECT_EQ(schedule.GamesWanted(), 0u);
}

TEST(Schedule, GrowingDataSetsTakeWhatIsThereWithoutAGap) {
  Schedule schedule({.iterations = 3, .decisions_per_iteration = 10, .growing = true});
  schedule.Add(0, 9);
  EXPECT_EQ(schedule.StartIteration(), std::nullopt) << "not enough";
  for (const std::uint64_t ticket : {1, 2, 3, 5, 6}) schedule.Add(ticket, 9);
  EXPECT_EQ(schedule.StartIteration(), (Range{{0, 3}}));
  EXPECT_EQ(schedule.StartIteration(), std::nullopt) << "ticket 4 is awaited";
  schedule.Add(4, 9);
  EXPECT_EQ(schedule.StartIteration(), (Range{{4, 6}}));
}

// Demonstrations: however many they are, the first iteration is of them and of nothing else.
TEST(Schedule, AClosedFirstDataSetIsTakenWhole) {
  for (const std::uint32_t decisions : {1u, 1000u}) {
    Schedule schedule = ThreeIterations();
    for (std::uint64_t ticket = 0; ticket < 4; ++ticket) schedule.Add(ticket, decisions);
    schedule.CloseFirstDataSet();
    EXPECT_EQ(schedule.next_ticket(), 4u);
    EXPECT_EQ(schedule.decisions_wanted(), 4 * decisions);
    schedule.Add(4, 20);
    EXPECT_EQ(schedule.StartIteration(), (Range{{0, 3}}));
    EXPECT_EQ(schedule.decisions_wanted(), 10u);
    EXPECT_EQ(schedule.GamesWanted(), 0u);
    EXPECT_EQ(schedule.StartIteration(), (Range{{4, 4}}));
    EXPECT_EQ(schedule.GamesWanted(), 1u);
  }
}

TEST(Schedule, TheLearningRateFallsByEqualFactors) {
  TrainingConfig training;
  training.iterations = 3;
  training.learning_rate = 0.04;
  EXPECT_DOUBLE_EQ(LearningRateAfter(training, 0), 0.04);
  EXPECT_DOUBLE_EQ(LearningRateAfter(training, 2.5), 0.04);
  training.final_learning_rate = 0.0004;
  EXPECT_DOUBLE_EQ(LearningRateAfter(training, 0), 0.04);
  EXPECT_DOUBLE_EQ(LearningRateAfter(training, 1.5), 0.004) << "within an iteration too";
  EXPECT_DOUBLE_EQ(LearningRateAfter(training, 3), 0.0004);
}

TEST(Schedule, TheLearningRateFollowsItsSchedule) {
  TrainingConfig training;
  training.iterations = 10;
  training.learning_rate = 0.05;
  training.final_learning_rate = 0.01;
  training.learning_rate_schedule = "cosine";
  EXPECT_DOUBLE_EQ(LearningRateAfter(training, 0), 0.05);
  EXPECT_DOUBLE_EQ(LearningRateAfter(training, 5), 0.03);
  EXPECT_GT(LearningRateAfter(training, 1), 0.048) << "slowly at first";
  EXPECT_DOUBLE_EQ(LearningRateAfter(training, 10), 0.01);
  training.learning_rate_schedule = "one_cycle";
  EXPECT_DOUBLE_EQ(LearningRateAfter(training, 0), 0.002);
  EXPECT_DOUBLE_EQ(LearningRateAfter(training, 1.5), 0.026);
  EXPECT_DOUBLE_EQ(LearningRateAfter(training, 3), 0.05);
  EXPECT_DOUBLE_EQ(LearningRateAfter(training, 6.5), 0.03);
  EXPECT_DOUBLE_EQ(LearningRateAfter(training, 10), 0.01);
}

TEST(Schedule, UntrainedWeightsAreNotPlayedWith) {
  EXPECT_EQ(VersionToPlay(0, FirstWeights::kUntrained), 0u);
  EXPECT_EQ(VersionToPlay(0, FirstWeights::kGiven), 1u);
  for (const auto first : {FirstWeights::kUntrained, FirstWeights::kGiven}) {
    EXPECT_EQ(VersionToPlay(1, first), 2u);
    EXPECT_EQ(VersionToPlay(7, first), 8u);
  }
}

TEST(Schedule, AWindowOfOneNeedsNoOldGames) {
  Schedule schedule({.iterations = 5, .decisions_per_iteration = 10}, {{0, 3}});
  EXPECT_TRUE(schedule.WindowOfNext().empty());
  EXPECT_EQ(schedule.Add(3, 10), Use::kNone);
}

}  // namespace
}  // namespace powderkeg

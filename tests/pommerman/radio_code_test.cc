#include "common/pommerman/radio_code.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "common/base/rng.h"
#include "common/pommerman/belief.h"
#include "common/pommerman/generate.h"
#include "common/pommerman/step.h"
#include "common/record/rule_based_seat.h"

namespace powderkeg {
namespace {

using Axis = RadioReport::Axis;
using Plan = RadioReport::Plan;

TEST(RadioCodeTest, EveryReportSurvivesTheTwoWords) {
  for (int step = 0; step < 2; ++step) {
    for (Cell cell = 0; cell < kCellCount; ++cell) {
      for (int action = 0; action < kActionCount; ++action) {
        const Message words = EncodeReport(step, cell, static_cast<Action>(action));
        for (const int word : words) EXPECT_TRUE(word >= 1 && word <= 7) << word;
        const auto report = DecodeReport(step, words);
        ASSERT_TRUE(report.has_value());
        EXPECT_EQ(report->axis, step == 0 ? Axis::kRow : Axis::kColumn);
        EXPECT_EQ(report->coordinate, step == 0 ? RowOf(cell) : ColumnOf(cell));
      }
    }
  }
}

TEST(RadioCodeTest, PlansAreTheMovesAlongTheAxis) {
  const Cell cell = CellAt(4, 7);
  EXPECT_EQ(DecodeReport(0, EncodeReport(0, cell, Action::kUp))->plan, Plan::kDecrease);
  EXPECT_EQ(DecodeReport(0, EncodeReport(0, cell, Action::kDown))->plan, Plan::kIncrease);
  EXPECT_EQ(DecodeReport(0, EncodeReport(0, cell, Action::kLeft))->plan, Plan::kStay);
  EXPECT_EQ(DecodeReport(1, EncodeReport(1, cell, Action::kLeft))->plan, Plan::kDecrease);
  EXPECT_EQ(DecodeReport(1, EncodeReport(1, cell, Action::kRight))->plan, Plan::kIncrease);
  EXPECT_EQ(DecodeReport(1, EncodeReport(1, cell, Action::kUp))->plan, Plan::kStay);
  EXPECT_EQ(DecodeReport(1, EncodeReport(1, cell, Action::kStop))->plan, Plan::kStay);
  EXPECT_EQ(DecodeReport(0, EncodeReport(0, cell, Action::kBomb))->plan, Plan::kBomb);
}

TEST(RadioCodeTest, SilenceAndForeignWordsAreIgnored) {
  EXPECT_EQ(DecodeReport(0, {0, 0}), std::nullopt);
  EXPECT_EQ(DecodeReport(0, {0, 3}), std::nullopt);
  EXPECT_EQ(DecodeReport(0, {8, 1}), std::nullopt);
  EXPECT_EQ(DecodeReport(0, {7, 255}), std::nullopt);
  EXPECT_EQ(DecodeReport(0, {7, 3}), std::nullopt);  // code 44
  EXPECT_NE(DecodeReport(0, {7, 2}), std::nullopt);  // code 43
}

TEST(MateTrackerTest, KnowsNothingUntilBothCoordinatesWereHeard) {
  MateTracker tracker;
  tracker.Hear(1, EncodeReport(0, CellAt(3, 4), Action::kDown));
  EXPECT_EQ(tracker.cell(), std::nullopt);
  tracker.Hear(2, EncodeReport(1, CellAt(4, 4), Action::kRight));
  EXPECT_EQ(tracker.cell(), CellAt(4, 5));
  tracker.Hear(3, {0, 0});
  EXPECT_EQ(tracker.cell(), CellAt(4, 5));
}

TEST(MateTrackerTest, BelievesASeenMateAsLongAsItsWordsAgree) {
  MateTracker tracker;
  tracker.Hear(1, EncodeReport(0, CellAt(3, 4), Action::kRight));
  tracker.Hear(2, EncodeReport(1, CellAt(3, 5), Action::kRight));
  EXPECT_EQ(tracker.cell(), CellAt(3, 6));
  tracker.See(2, CellAt(3, 5));  // the move failed
  EXPECT_EQ(tracker.cell(), CellAt(3, 5));
  tracker.Hear(5, EncodeReport(4, CellAt(5, 5), Action::kStop));
  EXPECT_EQ(tracker.cell(), CellAt(5, 5));
  tracker.Hear(6, EncodeReport(5, CellAt(5, 9), Action::kStop));  // four columns in three steps
  EXPECT_EQ(tracker.cell(), std::nullopt);
  tracker.Hear(7, EncodeReport(6, CellAt(5, 9), Action::kStop));
  EXPECT_EQ(tracker.cell(), std::nullopt) << "not for the rest of the game";
}

TEST(MateTrackerTest, RandomWordsAreSoonNotBelieved) {
  Rng rng(1);
  int believed = 0;
  for (int game = 0; game < 100; ++game) {
    MateTracker tracker;
    for (int step = 1; step <= 20; ++step) {
      tracker.Hear(step, {static_cast<std::uint8_t>(1 + rng.Below(7)),
                          static_cast<std::uint8_t>(1 + rng.Below(7))});
    }
    believed += tracker.cell().has_value() ? 1 : 0;
  }
  EXPECT_LE(believed, 1);
}

// Beliefs of agent 0 about its mate out of sight in radio games of SimpleUnbiased agents.
TEST(MateTrackerTest, ABeliefThatListensIsCloserToTheTruth) {
  const GameSettings settings = GameSettingsFor("PommeRadioCompetition-v2").value();
  int unseen = 0;
  int deaf_distance = 0;
  int distance = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    GameSetup setup;
    setup.settings = settings;
    setup.seed = seed;
    setup.seats.fill({.searches = false, .policy = PolicyKind::kSimpleUnbiased});
    std::array<RuleBasedSeat, kAgentCount> seats;
    for (AgentId id = 0; id < kAgentCount; ++id) seats[id] = RuleBasedSeat(setup, id);
    State state = GenerateStart(settings, setup.start, BoardRng(setup));
    Belief deaf(settings);
    Belief listening(settings);
    while (state.agents[0].alive && state.agents[2].alive && !OutcomeOf(settings, state).done) {
      Observation observation = Observe(settings, state, 0);
      listening.Observe(observation);
      observation.message = {};
      deaf.Observe(observation);
      const Cell mate = state.agents[2].cell;
      if (listening.visible().Has(mate)) {
        ASSERT_EQ(listening.state().agents[2].cell, mate);
      } else if (state.step >= 2) {
        ++unseen;
        deaf_distance += ManhattanDistance(deaf.state().agents[2].cell, mate);
        distance += ManhattanDistance(listening.state().agents[2].cell, mate);
      }
      JointAction actions{};
      std::array<Message, kAgentCount> words{};
      for (AgentId id = 0; id < kAgentCount; ++id) {
        if (state.agents[id].alive) actions[id] = seats[id].Decide(settings, state);
      }
      words[2] = EncodeReport(state.step, mate, actions[2]);
      Step(settings, actions, words, state);
    }
  }
  ASSERT_GT(unseen, 200);
  std::printf("mean distance of the unseen mate: %.2f, with its words %.2f\n",
              static_cast<double>(deaf_distance) / unseen, static_cast<double>(distance) / unseen);
  EXPECT_LT(distance, unseen);
  EXPECT_LT(3 * distance, deaf_distance);
}

TEST(MateTrackerTest, FollowsAWanderingMateWithinTwoRowsAndColumns) {
  const GameSettings settings = GameSettingsFor("PommeRadioCompetition-v2").value();
  State state = GenerateStart(settings, {}, Rng(5));
  Rng rng(6);
  MateTracker tracker;
  for (int step = 0; step < 200; ++step) {
    JointAction actions{};
    actions[2] = static_cast<Action>(rng.Below(5));  // moves, never bombs
    const Message words = EncodeReport(state.step, state.agents[2].cell, actions[2]);
    Step(settings, actions, state);
    tracker.Hear(state.step, words);
    if (step == 0) continue;
    ASSERT_TRUE(tracker.cell().has_value());
    EXPECT_LE(std::abs(RowOf(*tracker.cell()) - RowOf(state.agents[2].cell)), 2);
    EXPECT_LE(std::abs(ColumnOf(*tracker.cell()) - ColumnOf(state.agents[2].cell)), 2);
  }
}

}  // namespace
}  // namespace powderkeg

#include "actors/http/radio_code.h"

#include <gtest/gtest.h>

#include "common/base/rng.h"
#include "common/pommerman/generate.h"
#include "common/pommerman/step.h"

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

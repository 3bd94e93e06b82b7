#include "tools/viewer/viewer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "common/base/check.h"
#include "common/pommerman/generate.h"
#include "common/record/rule_based_seat.h"
#include "tests/pommerman/board_reader.h"
#include "tools/official/recorded_export.h"
#include "tools/official/recorded_replay.h"
#include "tools/viewer/stored_game.h"

namespace powderkeg {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// The game that the lines hold.
RecordedGame Read(const std::string& lines) {
  std::istringstream text(lines);
  RecordedGameReader reader(
      "export", [&text](std::string& line) { return static_cast<bool>(std::getline(text, line)); });
  RecordedGame game;
  EXPECT_TRUE(reader.Next(game));
  return game;
}

void ExpectEqual(const RecordedGame& a, const RecordedGame& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.environment, b.environment);
  EXPECT_EQ(a.tag, b.tag);
  EXPECT_EQ(a.settings, b.settings);
  EXPECT_EQ(a.start, b.start);
  EXPECT_EQ(a.observations, b.observations);
  EXPECT_EQ(a.result, b.result);
  EXPECT_EQ(a.winners, b.winners);
  ASSERT_EQ(a.steps.size(), b.steps.size());
  for (std::size_t i = 0; i < a.steps.size(); ++i) {
    EXPECT_EQ(a.steps[i].actions, b.steps[i].actions) << i;
    EXPECT_EQ(a.steps[i].messages, b.steps[i].messages) << i;
    EXPECT_EQ(a.steps[i].state, b.steps[i].state) << i;
    EXPECT_EQ(a.steps[i].rewards, b.steps[i].rewards) << i;
    EXPECT_EQ(a.steps[i].done, b.steps[i].done) << i;
    EXPECT_EQ(a.steps[i].observations, b.steps[i].observations) << i;
  }
}

// A whole game of rule-based seats.
GameRecord PlayedRecord(const char* environment) {
  GameRecord record;
  record.ticket = 7;
  record.evaluator = "uniform";
  record.setup.settings = GameSettingsFor(environment).value();
  record.setup.seed = 11;
  for (Seat& seat : record.setup.seats) seat.policy = PolicyKind::kSimpleUnbiased;
  std::array<RuleBasedSeat, kAgentCount> seats;
  for (AgentId id = 0; id < kAgentCount; ++id) seats[id] = RuleBasedSeat(record.setup, id);
  const GameSettings& settings = record.setup.settings;
  State state = GenerateStart(settings, record.setup.start, BoardRng(record.setup));
  while (!record.outcome.done) {
    JointAction actions{};
    for (AgentId id = 0; id < kAgentCount; ++id) {
      if (state.agents[id].alive) actions[id] = seats[id].Decide(settings, state);
    }
    Collapse(settings, state);
    Step(settings, actions, state);
    record.outcome = OutcomeOf(settings, state);
    record.actions.push_back(actions);
  }
  return record;
}

class ExportTest : public ::testing::TestWithParam<const char*> {};

TEST_P(ExportTest, RecordedGamesComeBackTheSame) {
  RecordedGameReader reader(StrCat("tests/data/", GetParam(), ".jsonl.gz"));
  std::size_t steps = 0;
  for (RecordedGame game; steps < 1000 && reader.Next(game); steps += game.steps.size()) {
    ExpectEqual(Read(RecordedLines(game)), game);
  }
}

INSTANTIATE_TEST_SUITE_P(Files, ExportTest,
                         ::testing::Values("ffa", "team", "radio", "corner", "one_vs_one"),
                         [](const auto& file) { return std::string(file.param); });

class StoredGameTest : public ::testing::TestWithParam<const char*> {};

TEST_P(StoredGameTest, OurRecordsReplayWithoutDifferences) {
  const GameRecord record = PlayedRecord(GetParam());
  const StoredGame stored = StoredGameFrom(record);
  EXPECT_EQ(stored.game.steps.size(), record.actions.size());
  EXPECT_EQ(stored.game.id, "ticket-7");
  EXPECT_EQ(stored.players[0], "simple_unbiased");
  EXPECT_TRUE(stored.game.steps.back().done);
  const RecordedGame exported = Read(RecordedLines(stored.game));
  EXPECT_THAT(ReplayDifferences(exported), IsEmpty());
  ExpectEqual(exported, stored.game);
}

INSTANTIATE_TEST_SUITE_P(Environments, StoredGameTest,
                         ::testing::Values("PommeFFACompetition-v0", "PommeTeamCompetition-v0",
                                           "PommeRadio-v2", "OneVsOne-v0"),
                         [](const auto& environment) {
                           const std::string id = environment.param;
                           return id.substr(0, id.find('-'));
                         });

TEST(StoredGameTest, AForgedRecordIsRefused) {
  GameRecord record = PlayedRecord("PommeFFACompetition-v0");
  record.setup.seed ^= 1;
  EXPECT_THROW((void)StoredGameFrom(record), Error);
}

TEST(ExportTest, AnUnknownModeIsRefused) {
  RecordedGame game;
  game.mode = "chess";
  EXPECT_THROW((void)RecordedLines(game), Error);
}

// --- The viewer ---------------------------------------------------------------------------------

StoredGame SmallGame() {
  StoredGame stored;
  stored.game.environment = "PommeFFACompetition-v0";
  stored.game.id = "example";
  stored.game.mode = "ffa";
  stored.game.start = FromText(R"(
      0.#+.......
      .o.........
      ..b.r.k....
      ...*.......
      ...........
      ...........
      ...........
      ...........
      ...........
      ...........
      1..........
      agent 0 ammo 2 strength 3 kick
      agent 1 ammo 1 strength 2
      bomb (1,1) owner 0 life 7 strength 3 moving left
      bomb (10,0) owner 1 life 5 strength 2
      flame (3,3) life 1
  )");
  RecordedStep step;
  step.actions = {Action::kDown, Action::kBomb, Action::kStop, Action::kStop};
  step.messages[0] = {3, 4};
  step.state = stored.game.start;
  step.state.step = 1;
  stored.game.steps.push_back(step);
  stored.game.result = Result::kWin;
  stored.game.winners = 1;
  stored.players = {"search", "simple_unbiased", "", ""};
  stored.tracks[0].decisions = {{.step = 0, .visits = {1, 0, 3, 0, 0, 0}, .value = 0.25F}};
  return stored;
}

TEST(ViewerTest, ShowsBoardTimersAndStatistics) {
  const std::string text = RenderStep(SmallGame(), 0, Colours::kNone);
  EXPECT_THAT(text, HasSubstr("PommeFFACompetition-v0 example step 0, 0 of 1\n"));
  EXPECT_THAT(text, HasSubstr("\n 0 A0 .. ## ++ .."));
  EXPECT_THAT(text, HasSubstr("\n 1 .. <7 .. .."));
  EXPECT_THAT(text, HasSubstr("\n 2 .. .. +b .. +r .. +k"));
  EXPECT_THAT(text, HasSubstr("\n 3 .. .. .. *1 .."));
  EXPECT_THAT(text, HasSubstr("\n10 15 .."));
  EXPECT_THAT(text, HasSubstr("A0 search at (0,0) ammo 2 strength 3 kick"));
  EXPECT_THAT(text, HasSubstr("A1 simple_unbiased at (10,0) ammo 1 strength 2\n"));
  EXPECT_THAT(text, HasSubstr("A2 died at (0,0)"));
  EXPECT_THAT(text, Not(HasSubstr("\033")));
}

TEST(ViewerTest, ShowsMovesAndTheSearch) {
  const std::string text = RenderStep(SmallGame(), 0, Colours::kNone);
  EXPECT_THAT(text, HasSubstr("plays down and says 3 4; visits stop 25% down 75%, value +0.25\n"));
  EXPECT_THAT(text, HasSubstr("plays bomb\n"));
  EXPECT_THAT(text, Not(HasSubstr("won by")));
}

TEST(ViewerTest, TheLastStepTellsTheResult) {
  StoredGame stored = SmallGame();
  EXPECT_THAT(RenderStep(stored, 1, Colours::kNone), HasSubstr("won by A0\n"));
  EXPECT_THAT(RenderStep(stored, 1, Colours::kNone), Not(HasSubstr("plays")));
  stored.game.result = Result::kTie;
  EXPECT_THAT(RenderStep(stored, 1, Colours::kNone), HasSubstr("tie\n"));
  stored.game.result = Result::kIncomplete;
  EXPECT_THAT(RenderStep(stored, 1, Colours::kNone), HasSubstr("the record ends here\n"));
}

TEST(ViewerTest, ColoursChangeNoText) {
  const StoredGame stored = SmallGame();
  std::string text = RenderStep(stored, 0, Colours::kAnsi);
  EXPECT_THAT(text, HasSubstr("\033["));
  for (std::size_t escape = 0; (escape = text.find('\033')) != std::string::npos;) {
    text.erase(escape, text.find('m', escape) - escape + 1);
  }
  EXPECT_EQ(text, RenderStep(stored, 0, Colours::kNone));
}

}  // namespace
}  // namespace powderkeg

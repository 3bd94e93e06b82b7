#include "tools/official/recorded_decisions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/check.h"
#include "common/recorded/json_lines.h"

namespace powderkeg {
namespace {

using ::testing::HasSubstr;

constexpr char kSimpleUnbiasedFile[] = "tests/data/simple_unbiased.jsonl.gz";
constexpr char kOfficialSimpleFile[] = "tests/data/simple_agent.jsonl.gz";

std::string FirstLine(const std::string& path) {
  LineReader reader(path);
  std::string line;
  EXPECT_TRUE(reader.Next(line));
  return line;
}

void ExpectError(PolicyKind kind, const std::string& line, const std::string& message) {
  try {
    (void)ParseRecordedDecision(kind, line);
    ADD_FAILURE() << "no error for " << line;
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(message));
  }
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::optional<std::string> Compare(PolicyKind kind, const RecordedDecision& record) {
  return CompareDecision(kind, record, 1e-6, SingleAction::kIsCertain, Rng(1));
}

TEST(RecordedDecisionsTest, SimpleUnbiasedDecidesAsRecorded) {
  EXPECT_EQ(RunDecisionsCheck("simple_unbiased", {kSimpleUnbiasedFile}), 0);
}

TEST(RecordedDecisionsTest, OfficialSimpleDecidesAsRecorded) {
  EXPECT_EQ(RunDecisionsCheck("official_simple", {kOfficialSimpleFile}), 0);
}

TEST(RecordedDecisionsTest, ReadsWhatTheAgentSaw) {
  const RecordedDecision record =
      ParseRecordedDecision(PolicyKind::kSimpleUnbiased, FirstLine(kSimpleUnbiasedFile));
  EXPECT_EQ(record.settings.mode, Mode::kFreeForAll);
  EXPECT_EQ(record.self, 1);
  EXPECT_EQ(record.state.agents[1].cell, CellAt(9, 7));
  EXPECT_EQ(record.state.agents[1].ammo, 0);
  EXPECT_EQ(record.state.AgentCells().Count(), 4);
  EXPECT_EQ(record.state.bomb_count, 3);
  EXPECT_EQ(record.state.BombAt(4)->life, 2);
  EXPECT_EQ(record.visible, BitBoard::All());
  EXPECT_EQ(record.memory.recent_count, 4);
  EXPECT_EQ(record.memory.recent[1], RememberedPosition(9, 8));
  EXPECT_EQ(record.counts, (std::array<int, 6>{0, 149, 44, 0, 63, 0}));
}

TEST(RecordedDecisionsTest, ReadsMemoryOfTheOfficialAgent) {
  const RecordedDecision record =
      ParseRecordedDecision(PolicyKind::kOfficialSimple, FirstLine(kOfficialSimpleFile));
  EXPECT_EQ(record.self, 3);
  EXPECT_EQ(record.memory.recent_count, 6);
  EXPECT_EQ(record.memory.previous_direction, 3);
  EXPECT_EQ(record.chosen, Action::kLeft);
  EXPECT_EQ(record.memory_after.recent[0], RememberedPosition(5, 5));
}

// Each record compared with the counts of the one before it: what differs must be seen to differ.
TEST(RecordedDecisionsTest, OtherDistributionsAreRefused) {
  for (const auto& [kind, file] : {std::pair{PolicyKind::kSimpleUnbiased, kSimpleUnbiasedFile},
                                   std::pair{PolicyKind::kOfficialSimple, kOfficialSimpleFile}}) {
    LineReader reader(file);
    std::string line;
    std::array<int, kActionCount> previous{};
    int different = 0, refused = 0;
    for (int i = 0; i < 300 && reader.Next(line); ++i) {
      RecordedDecision record = ParseRecordedDecision(kind, line);
      record.chosen = std::nullopt;
      std::swap(record.counts, previous);
      int distance = 0;
      for (int a = 0; a < kActionCount; ++a) distance += std::abs(record.counts[a] - previous[a]);
      const int calls = kind == PolicyKind::kSimpleUnbiased ? 256 : 64;
      if (i == 0 || distance < calls) continue;  // half of the probability elsewhere
      ++different;
      if (Compare(kind, record)) ++refused;
    }
    EXPECT_GT(different, 100);
    EXPECT_EQ(refused, different) << file;
  }
}

TEST(RecordedDecisionsTest, SingleActionMustBeMetInEveryCall) {
  RecordedDecision record =
      ParseRecordedDecision(PolicyKind::kSimpleUnbiased, FirstLine(kSimpleUnbiasedFile));
  record.counts = {0, 256, 0, 0, 0, 0};
  const auto difference = Compare(PolicyKind::kSimpleUnbiased, record);
  ASSERT_TRUE(difference);
  EXPECT_THAT(*difference, HasSubstr("recorded 0 256 0 0 0 0, ours 0 "));
  EXPECT_THAT(*difference, HasSubstr("agent 1, ammo 0, recent (9,9)"));
}

TEST(RecordedDecisionsTest, OtherMemoryAfterwardsIsRefused) {
  RecordedDecision record =
      ParseRecordedDecision(PolicyKind::kOfficialSimple, FirstLine(kOfficialSimpleFile));
  EXPECT_EQ(Compare(PolicyKind::kOfficialSimple, record), std::nullopt);
  record.memory_after.previous_direction = 2;
  const auto difference = Compare(PolicyKind::kOfficialSimple, record);
  ASSERT_TRUE(difference);
  EXPECT_THAT(*difference, HasSubstr("memory after action 3 never"));
}

TEST(RecordedDecisionsTest, MalformedRecordsAreErrors) {
  const PolicyKind kind = PolicyKind::kSimpleUnbiased;
  const std::string line = FirstLine(kSimpleUnbiasedFile);
  ExpectError(kind, "", "not a record of simple_unbiased");
  ExpectError(kind, "{}", "mode");
  ExpectError(kind, Replaced(line, "\"ffa\"", "\"solo\""),
              "mode solo, expected ffa, team or radio");
  ExpectError(kind, Replaced(line, "\"board\":\"1", "\"board\":\""),
              "board of 120 cells, expected");
  ExpectError(kind, Replaced(line, "\"board\":\"1", "\"board\":\"9"), "board value 9");
  ExpectError(kind, Replaced(line, "\"board\":\"1", "\"board\":\"-"),
              "board has a cell '-', expected");
  ExpectError(kind, Replaced(line, "\"position\":[9,7]", "\"position\":[9,6]"), "no agent");
  ExpectError(kind, Replaced(line, "\"id\":1", "\"id\":2"), "another");
  ExpectError(kind, Replaced(line, "[9,9]", "[9,12]"), "recent position 9,12");
  ExpectError(kind, Replaced(line, "[9,9]", "[9,9],[1,1],[1,1],[1,1]"), "7 recent positions");
  const std::string strength = "\"bomb_blast_strength\":\"";
  const auto digits = line.find(strength) + strength.size();
  ExpectError(kind, std::string(line).replace(digits, 121, std::string(121, '2')), "40 bombs");
  ExpectError(PolicyKind::kOfficialSimple, line, "not a record of official_simple");
}

TEST(RecordedDecisionsTest, BadInputIsAnError) {
  EXPECT_THROW((void)RunDecisionsCheck("idle", {kSimpleUnbiasedFile}), Error);
  EXPECT_THROW((void)RunDecisionsCheck("simple_unbiased", {"tests/data/nothing.jsonl"}), Error);
  EXPECT_THROW((void)RunDecisionsCheck("simple_unbiased", {kOfficialSimpleFile}), Error);
}

}  // namespace
}  // namespace powderkeg

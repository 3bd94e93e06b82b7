#include "learner/report/iteration_history.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <sstream>

#include "common/base/check.h"
#include "learner/report/figures.h"
#include "tests/learner/record_support.h"
#include "tests/learner/report_support.h"

namespace powderkeg {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

std::string Contents(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

class IterationHistoryTest : public testing::Test {
 protected:
  // A table with these iterations as this program writes it.
  std::string Csv(std::initializer_list<int> iterations) const {
    const fs::path path = folder_.path() / "expected.csv";
    fs::remove(path);
    IterationHistory history(path, 0);
    for (const int iteration : iterations) history.Append(ReportOf(iteration));
    return Contents(path);
  }
  std::string Row(int iteration) const {
    const std::string text = Csv({iteration});
    return text.substr(text.find('\n') + 1);
  }
  void WriteTable(const std::string& text) const { std::ofstream(path_) << text; }

  const TemporaryFolder folder_;
  const fs::path path_ = folder_.path() / "iterations.csv";
  const fs::path old_ = folder_.path() / "iterations.csv.old";
};

TEST_F(IterationHistoryTest, ARowIsThereWhenAppendReturns) {
  IterationHistory history(path_, 0);
  history.Append(ReportOf(1));
  EXPECT_EQ(Contents(path_), Csv({1}));
  EXPECT_TRUE(Row(1).starts_with("1,512,100123,,0.78125,")) << "empty: no exams";
  EXPECT_EQ(history.CsvAfter(0), Contents(path_));
}

TEST_F(IterationHistoryTest, LargeNumbersKeepTheirDigits) {
  IterationReport report = ReportOf(1);
  report.decisions = 123'456'789;
  IterationHistory history(path_, 0);
  history.Append(report);
  EXPECT_THAT(Contents(path_), HasSubstr("\n1,512,123456789,"));
}

TEST_F(IterationHistoryTest, HasTheIterationsFromBeforeARestart) {
  WriteTable(Csv({1, 2}));
  IterationHistory history(path_, 2);
  EXPECT_THAT(*history.last(),
              testing::Pointwise(testing::NanSensitiveDoubleNear(1e-4), ValuesOf(ReportOf(2))));
  history.Append(ReportOf(3));
  EXPECT_EQ(history.CsvAfter(0), Csv({1, 2, 3}));
  EXPECT_EQ(Contents(path_), Csv({1, 2, 3}));
  EXPECT_EQ(history.last()->front(), 3);
  EXPECT_FALSE(fs::exists(old_));
}

TEST_F(IterationHistoryTest, GivesOnlyWhatIsLater) {
  IterationHistory history(path_, 0);
  EXPECT_EQ(history.last(), std::nullopt);
  EXPECT_EQ(history.CsvAfter(0), Csv({}));
  for (const int iteration : {1, 2, 4}) history.Append(ReportOf(iteration));
  EXPECT_EQ(history.CsvAfter(-1), Csv({1, 2, 4}));
  EXPECT_EQ(history.CsvAfter(2), Csv({4}));
  EXPECT_EQ(history.CsvAfter(3), Csv({4}));
  EXPECT_EQ(history.CsvAfter(4), Csv({}));
}

// --- Files of other programs ------------------------------------------------------------------

TEST_F(IterationHistoryTest, AnOlderTableGoesOnWithTheColumnsItLacks) {
  WriteTable("iteration,decisions,games\n1,50025,202\n");
  IterationHistory history(path_, 1);
  const std::string first = history.CsvAfter(0);
  EXPECT_THAT(first, HasSubstr("\n1,202,50025,,,"));
  EXPECT_TRUE(first.starts_with(Csv({}).substr(0, 40)));
  EXPECT_EQ(Contents(path_), first);
  const std::vector<double> last = *history.last();
  EXPECT_EQ(last[2], 50025);
  EXPECT_THAT(last.back(), testing::IsNan());
  history.Append(ReportOf(2));
  EXPECT_EQ(Contents(path_), first + Row(2));
}

TEST_F(IterationHistoryTest, ColumnsThatItDoesNotKnowAreKept) {
  WriteTable("iteration,my notes,games\n1,hot day,202\n");
  IterationHistory history(path_, 1);
  history.Append(ReportOf(2));
  const std::string text = Contents(path_);
  EXPECT_THAT(text.substr(0, text.find('\n')), testing::EndsWith(",trained_s,my notes"));
  EXPECT_THAT(text, HasSubstr(",hot day\n2,"));
  EXPECT_EQ(IterationHistory(path_, 2).CsvAfter(0), text) << "they stay where they are";
}

TEST_F(IterationHistoryTest, AForeignFileIsNotOverwritten) {
  WriteTable("name,score\nx,1\n");
  EXPECT_THROW(IterationHistory(path_, 0), Error);
  EXPECT_EQ(Contents(path_), "name,score\nx,1\n");
  EXPECT_THROW(IterationHistory(folder_.path() / "missing" / "iterations.csv", 0), Error);
}

// --- Rows that go, or are gone -----------------------------------------------------------------

TEST_F(IterationHistoryTest, ARepeatedIterationReplacesItsRow) {
  WriteTable(Csv({1, 2, 3}));
  IterationHistory(path_, 2).Append(ReportOf(3));
  EXPECT_EQ(Contents(path_), Csv({1, 2, 3}));
  EXPECT_FALSE(fs::exists(old_)) << "killed between row and checkpoint: nothing is lost";
}

TEST_F(IterationHistoryTest, DamagedRowsGoAndTheOldTableIsKept) {
  const std::string row = Row(3);
  for (const std::string& damaged :
       {row.substr(0, row.size() - 1), row.substr(0, 9), "x" + row, row.substr(1), "," + row,
        "3" + row.substr(1, row.size() - 2) + ",\n", "0" + row.substr(1)}) {
    fs::remove(old_);
    WriteTable(Csv({1, 2}) + damaged);
    testing::internal::CaptureStderr();
    const IterationHistory history(path_, 3);
    EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr(" damaged=1 ")) << damaged;
    EXPECT_EQ(Contents(path_), Csv({1, 2})) << damaged;
    EXPECT_EQ(Contents(old_), Csv({1, 2}) + damaged);
  }
}

TEST_F(IterationHistoryTest, MissingRowsAreSaid) {
  WriteTable(Csv({1, 3}));
  testing::internal::CaptureStderr();
  const IterationHistory history(path_, 4);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr(" missing=2 of=4"));
  EXPECT_FALSE(fs::exists(old_));
}

TEST_F(IterationHistoryTest, RemovedCheckpointsDoNotEmptyTheTableSilently) {
  WriteTable(Csv({1, 2, 3}));
  testing::internal::CaptureStderr();
  const IterationHistory history(path_, 0);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("of_iterations_not_done=3"));
  EXPECT_EQ(Contents(path_), Csv({}));
  EXPECT_EQ(Contents(old_), Csv({1, 2, 3}));
}

// ---- Rows that the checkpoint has ---------------------------------------------------------------

TEST_F(IterationHistoryTest, WhatTheFileLacksComesFromTheCheckpoint) {
  const std::string row = Row(3);
  for (const std::string& file :
       {std::string(), Csv({1}), Csv({1, 3}), Csv({1, 2}) + row.substr(0, 20), Csv({1, 2, 3}),
        Csv({1}) + "2,9" + Row(2).substr(3) + row}) {
    fs::remove(path_);
    if (!file.empty()) WriteTable(file);
    testing::internal::CaptureStderr();
    const IterationHistory history(path_, 3, Csv({1, 2, 3}));
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_EQ(said.empty(), file == Csv({1, 2, 3})) << file;
    EXPECT_EQ(Contents(path_), Csv({1, 2, 3})) << file;
  }
}

TEST_F(IterationHistoryTest, OwnColumnsOfTheFileStayBesideTheCheckpointsRows) {
  WriteTable("iteration,my notes,games\n1,hot day,0\n");
  const IterationHistory history(path_, 2, Csv({1, 2}));
  const std::string row = Row(1);
  EXPECT_THAT(Contents(path_), HasSubstr(row.substr(0, row.size() - 1) + ",hot day\n2,"));
}

TEST_F(IterationHistoryTest, AppendGivesTheTableForTheCheckpoint) {
  IterationHistory history(path_, 0);
  EXPECT_EQ(history.Append(ReportOf(1)), Csv({1}));
}

// A restart on a full disk must not cost the rows of weeks.
TEST_F(IterationHistoryTest, AFullDiskIsAnErrorAndLosesNoRow) {
  {
    IterationHistory history(path_, 0);
    for (int iteration = 1; iteration <= 40; ++iteration) history.Append(ReportOf(iteration));
  }
  const std::string before = Contents(path_);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1024, 1024};
    setrlimit(RLIMIT_FSIZE, &limit);
    try {
      const IterationHistory history(path_, 40);
    } catch (const Error&) {
      _exit(0);
    }
    _exit(1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "no error";
  EXPECT_EQ(Contents(path_), before);
}

}  // namespace
}  // namespace powderkeg

#include "learner/report/iteration_history.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/learner/record_support.h"
#include "tests/learner/report_support.h"

namespace powderkeg {
namespace {

std::string Csv(std::initializer_list<int> iterations) {
  std::string text = IterationCsv::Header() + '\n';
  for (const int iteration : iterations) text += IterationCsv::Row(ReportOf(iteration)) + '\n';
  return text;
}

TEST(IterationHistory, HasTheIterationsFromBeforeARestart) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "iterations.csv";
  {
    IterationCsv csv(path, 1);
    for (const int iteration : {1, 2}) csv.Append(ReportOf(iteration));
  }
  IterationHistory history(path);
  EXPECT_EQ(history.last(), ReportOf(2));
  history.Append(ReportOf(3));
  EXPECT_EQ(history.CsvAfter(0), Csv({1, 2, 3}));
  EXPECT_EQ(history.last(), ReportOf(3));
}

TEST(IterationHistory, GivesOnlyWhatIsLater) {
  IterationHistory history("no/such/file");
  EXPECT_EQ(history.last(), std::nullopt);
  EXPECT_EQ(history.CsvAfter(0), Csv({}));
  for (const int iteration : {1, 2, 4}) history.Append(ReportOf(iteration));
  EXPECT_EQ(history.CsvAfter(-1), Csv({1, 2, 4}));
  EXPECT_EQ(history.CsvAfter(2), Csv({4}));
  EXPECT_EQ(history.CsvAfter(3), Csv({4}));
  EXPECT_EQ(history.CsvAfter(4), Csv({}));
  EXPECT_EQ(history.CsvAfter(100), Csv({}));
}

TEST(IterationHistory, LeavesOutWhatIsNoRow) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "iterations.csv";
  std::ofstream(path) << Csv({1}) << "2,torn\n" << IterationCsv::Row(ReportOf(3)) << "\n4,51";
  EXPECT_EQ(IterationHistory(path).CsvAfter(0), Csv({1, 3}));
}

}  // namespace
}  // namespace powderkeg

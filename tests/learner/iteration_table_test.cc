#include "learner/report/iteration_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/learner/report_support.h"

namespace powderkeg {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(IterationTable, LinesAreAlignedWithTheHeader) {
  const std::string header = TableHeader(ReportOf(7));
  const std::string line = TableLine(ReportOf(7));
  EXPECT_EQ(line.size(), TableLine(ReportOf(50)).size());
  EXPECT_EQ(header, TableHeader(ReportOf(50)));
  EXPECT_EQ(line.find(" 78.1"), header.find("win %"));
  EXPECT_EQ(line.find("31/14/15/16/14/10") + 17, header.find("bomb") + 4);
  EXPECT_EQ(line.find("0.900"), header.find("loss   "));
}

TEST(IterationTable, LineSaysSharesWithWilsonIntervals) {
  EXPECT_THAT(TableLine(ReportOf(7)), HasSubstr("78.1 [74.3- 81.5]"));
  IterationReport perfect = ReportOf(1);
  perfect.score = {.wins = 20, .ties = 0, .losses = 0};
  EXPECT_THAT(TableLine(perfect), HasSubstr("100.0 [83.9-100.0]"));
}

TEST(IterationTable, ExamsAreTheResultsWhereThereAreAny) {
  EXPECT_THAT(TableHeader(ReportOf(7)), Not(HasSubstr("exams")));
  IterationReport report = ReportOf(7);
  report.exams = {.wins = 10, .ties = 6, .losses = 4};
  EXPECT_THAT(TableHeader(report), HasSubstr("  exams  win %"));
  EXPECT_THAT(TableLine(report), HasSubstr("   20   50.0 [29.9- 70.1]   30.0 [14.5- 51.9]"));
}

TEST(IterationTable, NarrowTerminalsGetWholeColumns) {
  const IterationReport report = ReportOf(7);
  const std::string line = TableLine(report);
  EXPECT_EQ(TableLine(report, line.size()), line);
  EXPECT_EQ(TableHeader(report, 62), "iter  games  decisions  win %               tie %");
  EXPECT_EQ(TableLine(report, 62), line.substr(0, 62)) << line;
  for (std::size_t width = 0; width < 200; ++width) {
    ASSERT_LE(TableLine(report, width).size(), width);
    ASSERT_LE(TableHeader(report, width).size(), width);
    ASSERT_TRUE(line.starts_with(TableLine(report, width)));
  }
}

TEST(IterationTable, TheLogHasEveryFigureThatThereIs) {
  EXPECT_THAT(LogLine(ReportOf(7)), HasSubstr("iteration done iteration=7 games=512 "));
  EXPECT_THAT(LogLine(ReportOf(7)), HasSubstr(" trained_s=123"));
  EXPECT_THAT(LogLine(ReportOf(7)), Not(HasSubstr("exam")));
}

}  // namespace
}  // namespace powderkeg

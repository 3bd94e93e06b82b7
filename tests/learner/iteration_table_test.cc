#include "learner/report/iteration_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <limits>
#include <sstream>

#include "common/base/check.h"
#include "tests/learner/record_support.h"
#include "tests/learner/report_support.h"

namespace powderkeg {
namespace {

std::string Contents(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

std::string Rows(std::initializer_list<int> iterations) {
  std::string text = IterationCsv::Header() + '\n';
  for (const int iteration : iterations) text += IterationCsv::Row(ReportOf(iteration)) + '\n';
  return text;
}

TEST(IterationTable, LinesAreAlignedWithTheHeader) {
  EXPECT_EQ(TableLine(ReportOf(7)).size(), TableLine(ReportOf(50)).size());
  EXPECT_LE(TableLine(ReportOf(7)).size(), TableHeader().size());
  const std::string line = TableLine(ReportOf(7));
  EXPECT_EQ(line.find(" 78.1"), TableHeader().find("win %"));
  EXPECT_EQ(line.find("31/14/15/16/14/10"), TableHeader().find("stop/up"));
  EXPECT_EQ(line.find("0.900"), TableHeader().find("loss   "));
}

TEST(IterationTable, LineSaysSharesWithWilsonIntervals) {
  EXPECT_THAT(TableLine(ReportOf(7)), testing::HasSubstr("78.1 [74.3- 81.5]"));
  IterationReport perfect = ReportOf(1);
  perfect.score = {.wins = 20, .ties = 0, .losses = 0};
  EXPECT_THAT(TableLine(perfect), testing::HasSubstr("100.0 [83.9-100.0]"));
}

TEST(IterationTable, NarrowTerminalsGetWholeColumns) {
  const std::string line = TableLine(ReportOf(7));
  EXPECT_EQ(FitTable(line, line.size()), line);
  EXPECT_EQ(FitTable(TableHeader(), 79), "iter  games  decisions  win %               tie %");
  EXPECT_EQ(FitTable(line, 79), line.substr(0, 62)) << line;
  EXPECT_TRUE(FitTable(TableHeader(), 119).ends_with("  stop/up/down/left/right/bomb"));
  EXPECT_TRUE(FitTable(line, 119).ends_with("31/14/15/16/14/10"));
  for (std::size_t width = 0; width < 200; ++width) {
    ASSERT_LE(FitTable(line, width).size(), width);
    ASSERT_LE(FitTable(TableHeader(), width).size(), width);
  }
}

TEST(IterationCsv, HeaderAndRowsHaveAsManyColumns) {
  const std::string header = IterationCsv::Header();
  const std::string row = IterationCsv::Row(ReportOf(3));
  EXPECT_EQ(std::ranges::count(header, ','), std::ranges::count(row, ','));
  EXPECT_TRUE(row.starts_with("3,512,100123,400,50,62,0.78125,"));
}

TEST(IterationCsv, ARowIsReadBackAsItWasWritten) {
  IterationReport report = ReportOf(3);
  report.mean_steps = 123.456;
  EXPECT_EQ(IterationCsv::Parse(IterationCsv::Row(report)), report);
  report.value_loss = std::numeric_limits<double>::quiet_NaN();
  const auto parsed = IterationCsv::Parse(IterationCsv::Row(report));
  ASSERT_TRUE(parsed);
  EXPECT_TRUE(std::isnan(parsed->value_loss));
  EXPECT_EQ(IterationCsv::Row(*parsed), IterationCsv::Row(report));
}

TEST(IterationCsv, WhatIsNoRowIsNotRead) {
  const std::string row = IterationCsv::Row(ReportOf(3));
  for (const std::string& text : {std::string(), IterationCsv::Header(), row + ",", row + ",1",
                                  row + "x", row.substr(0, row.rfind(',')), "x" + row}) {
    EXPECT_EQ(IterationCsv::Parse(text), std::nullopt) << text;
  }
}

TEST(IterationCsv, WritesTheHeaderOnceAndAppendsOnResume) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "iterations.csv";
  {
    IterationCsv csv(path, 1);
    csv.Append(ReportOf(1));
    EXPECT_EQ(Contents(path), Rows({1})) << "a row is there when Append returns";
    csv.Append(ReportOf(2));
  }
  IterationCsv(path, 3).Append(ReportOf(3));
  EXPECT_EQ(Contents(path), Rows({1, 2, 3}));
}

TEST(IterationCsv, ARepeatedIterationReplacesItsRow) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "iterations.csv";
  {
    IterationCsv csv(path, 1);
    for (const int iteration : {1, 2, 3}) csv.Append(ReportOf(iteration));
  }
  IterationCsv(path, 3).Append(ReportOf(3));
  EXPECT_EQ(Contents(path), Rows({1, 2, 3}));
}

TEST(IterationCsv, ATornLastRowIsRemoved) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "iterations.csv";
  std::ofstream(path) << Rows({1}) << "2,512,1001";
  IterationCsv(path, 3).Append(ReportOf(3));
  EXPECT_EQ(Contents(path), Rows({1, 3}));
}

TEST(IterationCsv, AForeignFileIsNotOverwritten) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "iterations.csv";
  std::ofstream(path) << "name,score\nx,1\n";
  EXPECT_THROW(IterationCsv(path, 1), Error);
  EXPECT_EQ(Contents(path), "name,score\nx,1\n");
  EXPECT_THROW(IterationCsv(folder.path() / "missing" / "iterations.csv", 1), Error);
}

// A restart on a full disk must not cost the rows of weeks.
TEST(IterationCsv, AFullDiskIsAnErrorAndLosesNoRow) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "iterations.csv";
  {
    IterationCsv csv(path, 1);
    for (int iteration = 1; iteration <= 40; ++iteration) csv.Append(ReportOf(iteration));
  }
  const std::string before = Contents(path);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1024, 1024};
    setrlimit(RLIMIT_FSIZE, &limit);
    try {
      const IterationCsv csv(path, 41);
    } catch (const Error&) {
      _exit(0);
    }
    _exit(1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "no error";
  EXPECT_EQ(Contents(path), before);
}

}  // namespace
}  // namespace powderkeg

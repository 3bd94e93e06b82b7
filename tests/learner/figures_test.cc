#include "learner/report/figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "common/base/check.h"
#include "learner/report/iteration_history.h"
#include "learner/report/iteration_table.h"
#include "learner/report/metrics.h"
#include "learner/report/status_json.h"
#include "tests/learner/record_support.h"
#include "tests/learner/view_support.h"

namespace powderkeg {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

// A report that lacks nothing.
IterationReport WholeReport() {
  IterationReport report = ReportOf(2);
  report.exams = {.wins = 10, .ties = 6, .losses = 4};
  report.held_out_samples = 100;
  report.progress = {.elo = 120, .half_interval = 15};
  return report;
}

std::string Contents(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

double ValueOf(std::string_view name, const IterationReport& report) {
  const auto figures = IterationFigures();
  return std::ranges::find(figures, name, &Figure::name)->value(report);
}

// Whether the text holds the name by itself, not as a part of a longer one.
bool HasWord(const std::string& text, const std::string& name) {
  const auto is_part = [&](std::size_t place) {
    return place < text.size() &&
           (std::isalnum(static_cast<unsigned char>(text[place])) != 0 || text[place] == '_');
  };
  for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) {
    if (!is_part(at - 1) && !is_part(at + name.size())) return true;
  }
  return false;
}

TEST(Figures, OneEntryShowsAFigureEverywhere) {
  RunView view = PlayingRun();
  view.last_iteration = ValuesOf(WholeReport());
  const TemporaryFolder folder;
  IterationHistory history(folder.path() / "iterations.csv", 1);
  history.Append(WholeReport());
  const std::string header = "," + history.CsvAfter(2);
  const std::string metrics = MetricsText(view);
  const auto status = nlohmann::json::parse(StatusJson(view));
  for (const Figure& figure : IterationFigures()) {
    EXPECT_TRUE(std::isfinite(figure.value(WholeReport()))) << figure.name;
    EXPECT_THAT(header, testing::ContainsRegex(StrCat(",", figure.name, "[,\n]")));
    EXPECT_THAT(metrics,
                testing::ContainsRegex(StrCat("\npowderkeg_(iteration_)?", figure.name, " ")));
    EXPECT_THAT(status["last_iteration"].value(figure.name, 0.0),
                testing::DoubleNear(figure.value(WholeReport()), 1e-9));
    EXPECT_THAT(LogLine(WholeReport()), HasSubstr(StrCat(" ", figure.name, "=")));
    EXPECT_THAT(FiguresText(), HasSubstr(StrCat("\niteration\t", figure.name, "\t", figure.unit,
                                                "\t", figure.label, "\t")));
    if (figure.heading != nullptr) {
      EXPECT_THAT(TableHeader(WholeReport()), HasSubstr(figure.heading));
    }
  }
}

template <typename Source>
void ExpectEverywhere(std::span<const LiveFigure<Source>> figures, const std::string& of,
                      const std::string& metric, const nlohmann::json& json) {
  for (const auto& figure : figures) {
    EXPECT_TRUE(json.contains(figure.name)) << figure.name;
    EXPECT_THAT(MetricsText(PlayingRun()), HasSubstr(StrCat("# HELP ", metric, figure.name)));
    EXPECT_THAT(FiguresText(), HasSubstr(StrCat("\n", of, "\t", figure.name, "\t")));
  }
}

TEST(Figures, OneEntryShowsALiveFigureEverywhere) {
  const auto status = nlohmann::json::parse(StatusJson(PlayingRun()));
  ExpectEverywhere(RunFigures(), "run", "powderkeg_run_", status);
  ExpectEverywhere(IntakeFigures(), "intake", "powderkeg_", status["intake"]);
  ExpectEverywhere(ActorFigures(), "actor", "powderkeg_actor_", status["actors"][0]);
}

// What people and programs add to see more: no other file of the program may know a figure's name.
TEST(Figures, AFiguresNameStandsInOneProductFile) {
  std::string elsewhere = Contents("deploy/plot-iterations");
  for (const auto& entry : fs::recursive_directory_iterator("learner")) {
    const fs::path& path = entry.path();
    const bool holds_values = path.parent_path().filename() == "train";
    if (!entry.is_regular_file() || holds_values || path.filename() == "figures.cc") continue;
    elsewhere += Contents(path);
  }
  ASSERT_THAT(elsewhere, HasSubstr("<!doctype html>"));
  int distinctive = 0;
  for (const Figure& figure : IterationFigures()) {
    const std::string name = figure.name;
    if (name.find('_') == std::string::npos) continue;  // a word of every day, such as games
    ++distinctive;
    EXPECT_FALSE(HasWord(elsewhere, name)) << name;
  }
  EXPECT_GT(distinctive, 20);
}

TEST(Figures, NamesAreOnesAndTextsFitIntoTheirFormats) {
  std::set<std::string_view> names;
  for (const Figure& figure : IterationFigures()) {
    EXPECT_TRUE(names.insert(figure.name).second) << figure.name << " comes twice";
    EXPECT_THAT(figure.name, testing::MatchesRegex("[a-z][a-z0-9_]*"));
    EXPECT_THAT(figure.format, testing::MatchesRegex("[ [/-]*%[0-9]?\\.[0-9]f\\]?")) << figure.name;
    EXPECT_THAT(figure.help, testing::EndsWith("."));
  }
  const std::string text = FiguresText();
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_EQ(std::ranges::count(line, '\t'), 8) << line;
  }
}

TEST(Figures, ExamsAreTheMeasureWhereThereAreAny) {
  EXPECT_EQ(ValueOf("win_rate", ReportOf(1)), 0.78125) << "of the games trained on";
  EXPECT_THAT(ValueOf("exam_wins", ReportOf(1)), testing::IsNan());
  EXPECT_EQ(ValueOf("win_rate", WholeReport()), 0.5);
  EXPECT_EQ(ValueOf("tie_rate", WholeReport()), 0.3);
  EXPECT_EQ(ValueOf("loss_rate", WholeReport()), 0.2);
  EXPECT_EQ(ValueOf("win_rate_low95", WholeReport()), WilsonInterval(10, 20).low);
  EXPECT_EQ(ValueOf("wins", WholeReport()), 400) << "of the games trained on";
  EXPECT_EQ(ValueOf("exam_wins", WholeReport()), 10);
  IterationReport without = ReportOf(1);
  without.score = {};
  EXPECT_THAT(ValueOf("win_rate", without), testing::IsNan());
  EXPECT_THAT(ValueOf("win_rate_low95", without), testing::IsNan());
}

}  // namespace
}  // namespace powderkeg

#include "learner/report/iteration_table.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "common/base/format.h"
#include "common/base/log.h"
#include "learner/report/figures.h"

namespace powderkeg {
namespace {

struct Column {
  std::string_view heading;
  std::string cell;

  [[nodiscard]] std::size_t width() const { return std::max(heading.size(), cell.size()); }
};

std::string Cell(const Figure& figure, double value) {
  return Format(figure.format, std::string_view(figure.unit) == "%" ? 100 * value : value);
}

// Those that fit, two spaces apart.
std::vector<Column> ColumnsOf(const IterationReport& report, std::size_t width) {
  std::vector<Column> columns;
  for (const Figure& figure : IterationFigures()) {
    const double value = figure.value(report);
    if (figure.heading == nullptr || !std::isfinite(value)) continue;
    const bool shared = !columns.empty() && columns.back().heading == figure.heading;
    if (!shared) columns.push_back({figure.heading, ""});
    columns.back().cell += Cell(figure, value);
  }
  std::size_t end = 0;
  const auto fits = [&](const Column& column) { return (end += column.width() + 2) - 2 <= width; };
  columns.erase(std::ranges::find_if_not(columns, fits), columns.end());
  return columns;
}

}  // namespace

std::string TableHeader(const IterationReport& report, std::size_t width) {
  std::string line;
  for (const Column& column : ColumnsOf(report, width)) {
    (line += column.heading).append(column.width() + 2 - column.heading.size(), ' ');
  }
  return line.substr(0, line.find_last_not_of(' ') + 1);
}

std::string TableLine(const IterationReport& report, std::size_t width) {
  std::string line;
  for (const Column& column : ColumnsOf(report, width)) {
    if (!line.empty()) line += "  ";
    line.append(column.width() - column.cell.size(), ' ') += column.cell;
  }
  return line;
}

std::string LogLine(const IterationReport& report) {
  std::string line = "iteration done";
  for (const Figure& figure : IterationFigures()) {
    const double value = figure.value(report);
    if (std::isfinite(value)) log::AppendFields(line, figure.name, value);
  }
  return line;
}

}  // namespace powderkeg

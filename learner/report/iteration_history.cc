#include "learner/report/iteration_history.h"

#include <algorithm>
#include <cmath>
#include <ranges>
#include <span>
#include <sstream>
#include <string_view>
#include <utility>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/durable_file.h"
#include "common/base/format.h"
#include "common/base/log.h"
#include "common/base/number.h"
#include "learner/report/figures.h"

namespace powderkeg {
namespace {

using Cells = std::vector<std::string>;

Cells CellsOf(std::string_view line) {
  Cells cells(1);
  for (const char c : line) {
    if (c == ',') {
      cells.emplace_back();
    } else if (c != '\r' && c != '\n') {
      cells.back() += c;
    }
  }
  return cells;
}

std::string LineOf(std::span<const std::string> cells) {
  std::string line;
  for (const std::string& cell : cells) (line += cell) += ',';
  line.back() = '\n';
  return line;
}

// All digits of a whole number, else six; nothing of what is absent.
std::string Text(double value) {
  if (!std::isfinite(value)) return "";
  const bool whole = value == std::trunc(value) && std::abs(value) < 1e15;
  return Format(whole ? "%.0f" : "%.6g", value);
}

// nullopt: the text is no number.
std::optional<double> NumberIn(std::string_view cell) {
  return cell.empty() ? kAbsent : ParseNumber<double>(cell);
}

// The cells in the order of `columns`, empty where the header lacks one.
Cells Ordered(const Cells& cells, const Cells& header, const Cells& columns) {
  Cells ordered;
  for (const std::string& column : columns) {
    const auto place = static_cast<std::size_t>(std::ranges::find(header, column) - header.begin());
    ordered.push_back(place < cells.size() ? cells[place] : "");
  }
  return ordered;
}

// The iteration of a row in the order of the figures; nullopt if it is damaged.
std::optional<int> IterationOf(const Cells& row) {
  for (std::size_t i = 0; i < IterationFigures().size(); ++i) {
    if (!NumberIn(row[i])) return std::nullopt;
  }
  const double iteration = *NumberIn(row.front());
  if (!(iteration >= 1 && iteration < 1e9) || iteration != std::trunc(iteration))
    return std::nullopt;
  return static_cast<int>(iteration);
}

}  // namespace

IterationHistory::IterationHistory(std::filesystem::path path, int iterations_done,
                                   const std::string& kept)
    : path_(std::move(path)) {
  for (const Figure& figure : IterationFigures()) columns_.emplace_back(figure.name);
  std::vector<std::uint8_t> bytes;
  if (std::filesystem::exists(path_)) bytes = ReadFileBytes(path_);
  const std::string file(bytes.begin(), bytes.end());
  AddColumns(file);
  AddColumns(kept);
  Read(file, iterations_done);
  Restore(kept);
  if (const std::size_t done = static_cast<std::size_t>(iterations_done); rows_.size() < done) {
    log::Warn("the table lacks rows of finished iterations: their figures are lost", "table",
              path_.string(), "missing", done - rows_.size(), "of", done);
  }
  Write();
}

// Those that the table has and no other so far.
void IterationHistory::AddColumns(const std::string& table) {
  const Cells header = CellsOf(table.substr(0, table.find('\n')));
  if (table.empty()) return;
  if (header.front() != columns_.front()) {
    throw Error(StrCat(path_.string(), " begins with '", header.front(),
                       "', expected a table whose first column is ", columns_.front()));
  }
  std::ranges::copy_if(header, std::back_inserter(columns_), [this](const std::string& column) {
    return std::ranges::find(columns_, column) == columns_.end();
  });
}

void IterationHistory::Read(const std::string& table, int iterations_done) {
  std::istringstream lines(table);
  std::string line;
  std::getline(lines, line);
  const Cells header = CellsOf(line);
  int damaged = 0;
  int later = 0;
  while (std::getline(lines, line)) {
    const Cells cells = CellsOf(line);
    const Cells row = Ordered(cells, header, columns_);
    const auto iteration = IterationOf(row);
    if (!iteration || cells.size() != header.size() || lines.eof()) {
      ++damaged;
    } else if (*iteration > iterations_done) {
      ++later;
    } else {
      rows_.insert_or_assign(*iteration, LineOf(row));
    }
  }
  if (damaged == 0 && later <= 1) return;
  WriteFileDurably(path_.string() + ".old", BytesOf(table));
  log::Warn("rows go; the table as it was is kept beside it as .old", "table", path_.string(),
            "damaged", damaged, "of_iterations_not_done", later);
}

// The figures of the rows of `kept`; columns that only the file has are the file's.
void IterationHistory::Restore(const std::string& kept) {
  std::istringstream lines(kept);
  std::string line;
  std::getline(lines, line);
  const Cells header = CellsOf(line);
  int restored = 0;
  while (std::getline(lines, line)) {
    Cells row = Ordered(CellsOf(line), header, columns_);
    std::string& known = rows_[IterationOf(row).value()];
    if (!known.empty()) {
      const auto figures = static_cast<std::ptrdiff_t>(IterationFigures().size());
      std::ranges::copy(CellsOf(known) | std::views::drop(figures), row.begin() + figures);
    }
    if (LineOf(row) == known) continue;
    known = LineOf(row);
    ++restored;
  }
  if (restored == 0) return;
  log::Warn("rows were missing or other than the checkpoint has them: they are restored", "table",
            path_.string(), "rows", restored);
}

void IterationHistory::Write() const { WriteFileDurably(path_, BytesOf(CsvAfter(0))); }

std::string IterationHistory::Append(const IterationReport& report) {
  Cells cells(columns_.size());
  std::ranges::transform(ValuesOf(report), cells.begin(), Text);
  {
    const std::lock_guard lock(mutex_);
    rows_.insert_or_assign(report.iteration, LineOf(cells));
  }
  Write();
  return CsvAfter(0);
}

std::string IterationHistory::CsvAfter(int iteration) const {
  std::string text = LineOf(columns_);
  const std::lock_guard lock(mutex_);
  for (auto row = rows_.upper_bound(iteration); row != rows_.end(); ++row) text += row->second;
  return text;
}

std::optional<std::vector<double>> IterationHistory::last() const {
  const std::lock_guard lock(mutex_);
  if (rows_.empty()) return std::nullopt;
  const Cells cells = CellsOf(rows_.rbegin()->second);
  std::vector<double> values;
  for (std::size_t i = 0; i < IterationFigures().size(); ++i) {
    values.push_back(NumberIn(cells[i]).value_or(kAbsent));
  }
  return values;
}

}  // namespace powderkeg

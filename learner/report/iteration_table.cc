#include "learner/report/iteration_table.h"

#include <array>
#include <cstdarg>
#include <cstdio>
#include <sstream>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/durable_file.h"

namespace powderkeg {
namespace {

[[gnu::format(printf, 1, 2)]] std::string Format(const char* format, ...) {
  std::array<char, 256> text;
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text.data(), text.size(), format, arguments);
  va_end(arguments);
  return text.data();
}

double Share(std::uint64_t count, std::uint64_t total) {
  return total == 0 ? 0 : static_cast<double>(count) / static_cast<double>(total);
}

// " 78.2 [75.1-81.0]"
std::string Percentage(std::uint64_t count, std::uint64_t total) {
  const Interval interval = WilsonInterval(count, total);
  return Format("%5.1f [%4.1f-%5.1f]", 100 * Share(count, total), 100 * interval.low,
                100 * interval.high);
}

// One column of the CSV file.
struct Column {
  const char* name;
  std::string value;
};

std::vector<Column> ColumnsOf(const IterationReport& report) {
  const auto& [wins, ties, losses] = report.score;
  const Interval win_interval = WilsonInterval(wins, report.score.games());
  const auto number = [](double value) { return Format("%.6g", value); };
  const auto& shares = report.action_shares;
  return {{"iteration", std::to_string(report.iteration)},
          {"games", std::to_string(report.games)},
          {"decisions", std::to_string(report.decisions)},
          {"wins", std::to_string(wins)},
          {"ties", std::to_string(ties)},
          {"losses", std::to_string(losses)},
          {"win_rate", number(Share(wins, report.score.games()))},
          {"win_rate_low95", number(win_interval.low)},
          {"win_rate_high95", number(win_interval.high)},
          {"mean_steps", number(report.mean_steps)},
          {"share_stop", number(shares[0])},
          {"share_up", number(shares[1])},
          {"share_down", number(shares[2])},
          {"share_left", number(shares[3])},
          {"share_right", number(shares[4])},
          {"share_bomb", number(shares[5])},
          {"weights_lag", number(report.weights_lag)},
          {"total_loss", number(report.total_loss)},
          {"policy_loss", number(report.policy_loss)},
          {"value_loss", number(report.value_loss)},
          {"policy_accuracy", number(report.policy_accuracy)},
          {"samples_per_s", number(report.samples_per_s)},
          {"waited_s", number(report.waited_s)},
          {"trained_s", number(report.trained_s)}};
}

template <typename Field>
std::string Joined(const IterationReport& report, Field field) {
  std::string line;
  for (const Column& column : ColumnsOf(report)) {
    if (!line.empty()) line += ',';
    line += column.*field;
  }
  return line;
}

// The whole rows before `next_iteration`. The last line counts only with its line end.
std::string RowsToKeep(const std::filesystem::path& path, int next_iteration) {
  std::ifstream file(path);
  std::string kept = IterationCsv::Header() + '\n';
  std::string line;
  if (!std::getline(file, line) || file.eof()) return kept;
  if (line != IterationCsv::Header()) {
    throw Error(StrCat(path.string(), " has another header than this program writes: ", line));
  }
  while (std::getline(file, line) && !file.eof()) {
    if (std::atoi(line.c_str()) < next_iteration) kept += line + '\n';
  }
  return kept;
}

}  // namespace

std::string TableHeader() {
  return "iter  games  decisions  win %               tie %               loss %              "
         "steps  stop/up/down/left/right/bomb  loss   policy value  agree  lag  samples/s  "
         "wait s  train s";
}

std::string TableLine(const IterationReport& report) {
  const auto& [wins, ties, losses] = report.score;
  const std::uint64_t results = report.score.games();
  std::string shares;
  for (const double share : report.action_shares) {
    shares += Format(shares.empty() ? "%2.0f" : "/%2.0f", 100 * share);
  }
  return Format("%4d %6llu %10llu  ", report.iteration,
                static_cast<unsigned long long>(report.games),
                static_cast<unsigned long long>(report.decisions)) +
         Percentage(wins, results) + "  " + Percentage(ties, results) + "  " +
         Percentage(losses, results) + Format("  %5.1f  %-28s", report.mean_steps, shares.c_str()) +
         Format("  %.3f  %.3f  %.3f  %5.3f  %3.1f  %9.0f  %6.0f  %7.0f", report.total_loss,
                report.policy_loss, report.value_loss, report.policy_accuracy, report.weights_lag,
                report.samples_per_s, report.waited_s, report.trained_s);
}

std::string FitTable(const std::string& line, std::size_t width) {
  if (line.size() <= width) return line;
  const std::string header = TableHeader();
  std::size_t end = 0;  // of the last column that fits
  for (std::size_t i = 2; i < header.size() && i <= width + 2; ++i) {
    if (header[i] != ' ' && header[i - 1] == ' ' && header[i - 2] == ' ') end = i - 2;
  }
  const std::string fitted = line.substr(0, end);
  return fitted.substr(0, fitted.find_last_not_of(' ') + 1);
}

std::string IterationCsv::Header() { return Joined(IterationReport{}, &Column::name); }

std::string IterationCsv::Row(const IterationReport& report) {
  return Joined(report, &Column::value);
}

IterationCsv::IterationCsv(std::filesystem::path path, int next_iteration)
    : path_(std::move(path)) {
  WriteFileDurably(path_, BytesOf(RowsToKeep(path_, next_iteration)));
  file_.open(path_, std::ios::app);
  if (!file_) throw Error(StrCat("cannot open ", path_.string(), " to append to it"));
}

void IterationCsv::Append(const IterationReport& report) {
  file_ << Row(report) + '\n' << std::flush;
  if (!file_) throw Error(StrCat("cannot write ", path_.string(), ": is the disk full?"));
}

}  // namespace powderkeg

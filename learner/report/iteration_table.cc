#include "learner/report/iteration_table.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <type_traits>
#include <utility>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/durable_file.h"
#include "common/base/format.h"

namespace powderkeg {
namespace {

double Share(std::uint64_t count, std::uint64_t total) {
  return total == 0 ? 0 : static_cast<double>(count) / static_cast<double>(total);
}

// " 78.2 [75.1-81.0]"
std::string Percentage(std::uint64_t count, std::uint64_t total) {
  const Interval interval = WilsonInterval(count, total);
  return Format("%5.1f [%4.1f-%5.1f]", 100 * Share(count, total), 100 * interval.low,
                100 * interval.high);
}

// Calls visit(name, value) for each column of the CSV file. The values can be set, but for those
// that follow from others.
template <typename Report, typename Visit>
void VisitColumns(Report& report, Visit visit) {
  constexpr std::array<const char*, kActionCount> kShares = {
      "share_stop", "share_up", "share_down", "share_left", "share_right", "share_bomb"};
  visit("iteration", report.iteration);
  visit("games", report.games);
  visit("decisions", report.decisions);
  visit("wins", report.score.wins);
  visit("ties", report.score.ties);
  visit("losses", report.score.losses);
  const std::uint64_t results = report.score.games();
  const double win_rate = Share(report.score.wins, results);
  const Interval win_interval = WilsonInterval(report.score.wins, results);
  visit("win_rate", win_rate);
  visit("win_rate_low95", win_interval.low);
  visit("win_rate_high95", win_interval.high);
  visit("mean_steps", report.mean_steps);
  for (std::size_t i = 0; i < kShares.size(); ++i) visit(kShares[i], report.action_shares[i]);
  visit("weights_lag", report.weights_lag);
  visit("total_loss", report.total_loss);
  visit("policy_loss", report.policy_loss);
  visit("value_loss", report.value_loss);
  visit("policy_accuracy", report.policy_accuracy);
  visit("samples_per_s", report.samples_per_s);
  visit("waited_s", report.waited_s);
  visit("trained_s", report.trained_s);
}

void AppendCell(std::string& line, const std::string& cell) {
  if (!line.empty()) line += ',';
  line += cell;
}

template <typename Number>
std::string Text(Number number) {
  if constexpr (std::is_integral_v<Number>) return std::to_string(number);
  return Format("%.6g", static_cast<double>(number));
}

// Takes the cells of a row off one by one, into the values of its columns.
class RowReader {
 public:
  explicit RowReader(std::string_view row) : rest_(row) {}

  template <typename Number>
  void Read(Number& value) {
    const std::string_view cell = rest_.substr(0, rest_.find(','));
    std::remove_const_t<Number> number{};
    const auto [end, error] = std::from_chars(cell.begin(), cell.end(), number);
    good_ = good_ && error == std::errc() && end == cell.end();
    if constexpr (!std::is_const_v<Number>) value = number;
    ended_ = cell.size() == rest_.size();
    rest_.remove_prefix(std::min(cell.size() + 1, rest_.size()));
  }

  // Whether every cell was a number, and the last one the row's last.
  [[nodiscard]] bool good() const { return good_ && ended_; }

 private:
  std::string_view rest_;
  bool good_ = true;
  bool ended_ = false;
};

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

std::string IterationCsv::Header() {
  std::string line;
  const IterationReport report;
  VisitColumns(report, [&line](const char* name, const auto&) { AppendCell(line, name); });
  return line;
}

std::string IterationCsv::Row(const IterationReport& report) {
  std::string line;
  VisitColumns(report, [&line](const char*, auto value) { AppendCell(line, Text(value)); });
  return line;
}

std::optional<IterationReport> IterationCsv::Parse(std::string_view row) {
  IterationReport report;
  RowReader reader(row);
  VisitColumns(report, [&reader](const char*, auto& value) { reader.Read(value); });
  if (!reader.good()) return std::nullopt;
  return report;
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

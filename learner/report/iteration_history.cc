#include "learner/report/iteration_history.h"

#include <algorithm>
#include <fstream>

namespace powderkeg {

IterationHistory::IterationHistory(const std::filesystem::path& csv) {
  std::ifstream file(csv);
  for (std::string line; std::getline(file, line);) {
    if (const auto report = IterationCsv::Parse(line)) reports_.push_back(*report);
  }
}

void IterationHistory::Append(const IterationReport& report) {
  const std::lock_guard lock(mutex_);
  reports_.push_back(report);
}

std::string IterationHistory::CsvAfter(int iteration) const {
  std::vector<IterationReport> later;
  {
    const std::lock_guard lock(mutex_);
    const auto first =
        std::ranges::upper_bound(reports_, iteration, {}, &IterationReport::iteration);
    later.assign(first, reports_.end());
  }
  std::string text = IterationCsv::Header() + '\n';
  for (const IterationReport& report : later) text += IterationCsv::Row(report) + '\n';
  return text;
}

std::optional<IterationReport> IterationHistory::last() const {
  const std::lock_guard lock(mutex_);
  if (reports_.empty()) return std::nullopt;
  return reports_.back();
}

}  // namespace powderkeg

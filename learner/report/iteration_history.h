#pragma once

// The iterations of a run from its beginning, for whoever asks while it goes on.

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "learner/report/iteration_table.h"

namespace powderkeg {

// Thread-safe; nobody waits for a disk.
class IterationHistory {
 public:
  // Begins with the rows of iterations.csv, if there is such a file. What is no row is left out.
  explicit IterationHistory(const std::filesystem::path& csv);

  // Iterations ascend.
  void Append(const IterationReport& report);

  // As in iterations.csv: the header, then a row for each iteration later than this one.
  [[nodiscard]] std::string CsvAfter(int iteration) const;

  [[nodiscard]] std::optional<IterationReport> last() const;

 private:
  mutable std::mutex mutex_;  // guards what follows
  std::vector<IterationReport> reports_;
};

}  // namespace powderkeg

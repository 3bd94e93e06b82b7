#pragma once

// The iterations of a run from its beginning: the file iterations.csv, and for whoever asks.

#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "learner/train/iteration_report.h"

namespace powderkeg {

// The file has a header, then one row for each iteration, and is whole at any moment. It is read by
// its header: columns that it lacks are added, empty in its rows, and those that only it has are
// kept. Thread-safe; nobody who asks waits for a disk.
class IterationHistory {
 public:
  // Reads the file, if there is one, and writes what it is from now on. `kept` is what Append gave
  // for the iteration that was the last (the checkpoint has it): the file's rows are made as they
  // were then. Rows of iterations that are not done (and now repeated) go. Warns of rows that are
  // damaged, missing or other; before any goes that cannot be had again the file is kept as
  // PATH.old. Throws Error if it is no such file, which is then untouched, or cannot be written.
  IterationHistory(std::filesystem::path path, int iterations_done, const std::string& kept = {});

  // Iterations ascend. Durable when it returns the whole table; throws Error.
  std::string Append(const IterationReport& report);

  // As in the file: the header, then a row for each iteration later than this one.
  [[nodiscard]] std::string CsvAfter(int iteration) const;

  // Of IterationFigures(), to the six digits that are written; kAbsent where the file has none.
  [[nodiscard]] std::optional<std::vector<double>> last() const;

 private:
  void AddColumns(const std::string& table);
  void Read(const std::string& table, int iterations_done);
  void Restore(const std::string& kept);
  void Write() const;

  const std::filesystem::path path_;
  std::vector<std::string> columns_;  // every figure, then what only the file has

  mutable std::mutex mutex_;         // guards what follows
  std::map<int, std::string> rows_;  // by iteration
};

}  // namespace powderkeg

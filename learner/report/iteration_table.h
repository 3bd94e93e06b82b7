#pragma once

// What a run has to say after each iteration: one line of a table and one row of a CSV file.

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/stats.h"
#include "common/pommerman/types.h"

namespace powderkeg {

struct IterationReport {
  int iteration = 0;  // from 1
  std::uint64_t games = 0;
  std::uint64_t decisions = 0;
  MatchScore score;                                  // of the searching agents
  double mean_steps = 0;                             // per game
  std::array<double, kActionCount> action_shares{};  // of searched moves; sum 1
  double weights_lag = 0;  // mean age of the weights that games started with, in versions
  double total_loss = 0;
  double policy_loss = 0;
  double value_loss = 0;
  double policy_accuracy = 0;  // how often the network's best action is the target's
  double samples_per_s = 0;    // trained
  double waited_s = 0;         // for games
  double trained_s = 0;

  friend bool operator==(const IterationReport&, const IterationReport&) = default;
};

// The head of the table and a line of it, columns aligned, without line ends. Win, tie and loss are
// in percent with 95 % Wilson intervals.
[[nodiscard]] std::string TableHeader();
[[nodiscard]] std::string TableLine(const IterationReport& report);
// A header or line without the last columns, as many as it takes to be at most `width` characters.
[[nodiscard]] std::string FitTable(const std::string& line, std::size_t width);

// The file iterations.csv of a run: a header, then one row per iteration, whole once Append
// returned. One owner.
class IterationCsv {
 public:
  // Opens or creates the file. Rows of `next_iteration` and later (of an iteration that is now
  // repeated) and a torn last row are removed. Throws Error if the file cannot be written or has
  // another header.
  IterationCsv(std::filesystem::path path, int next_iteration);

  // Throws Error.
  void Append(const IterationReport& report);

  [[nodiscard]] static std::string Header();
  [[nodiscard]] static std::string Row(const IterationReport& report);
  // The report of a row, to the six digits that are written; nullopt if it is none.
  [[nodiscard]] static std::optional<IterationReport> Parse(std::string_view row);

 private:
  std::filesystem::path path_;
  std::ofstream file_;
};

}  // namespace powderkeg

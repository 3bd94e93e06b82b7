#pragma once

// How every version of the weights did in each exam.

#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "common/record/game_setup.h"
#include "learner/league/score_file.h"
#include "learner/replay/lessons.h"

namespace powderkeg {

// One official result for each measured side and game, and for the weights it played with: the
// file exams.csv of a run. Thread-safe.
class Exams {
 public:
  // Throws Error if the file is damaged.
  Exams(const std::filesystem::path& file, const RunGames& games, int iterations_done);

  // The results of an iteration, durable when it returns. Throws Error. One thread.
  void Add(int iteration, std::span<const GameResult> results);

  struct Row {
    std::string exam;  // Lineup::name
    MatchScore score;
  };
  // Of the games of an iteration, whatever their versions.
  [[nodiscard]] std::vector<Row> Of(int iteration) const;
  // The file's header and the rows of iterations later than `iteration`.
  [[nodiscard]] std::string CsvAfter(int iteration) const;

 private:
  const ScoreFile file_;
  std::vector<std::string> names_;  // by line-up; empty: no exam
  mutable std::mutex mutex_;        // guards the rest
  ScoreRows rows_;
};

}  // namespace powderkeg

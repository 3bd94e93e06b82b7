#include "learner/league/exams.h"

#include <map>

#include "common/base/check.h"

namespace powderkeg {

Exams::Exams(const std::filesystem::path& file, const RunGames& games, int iterations_done)
    : file_{.path = file, .first = "version", .second = "exam"},
      rows_(file_.Read(iterations_done)) {
  for (const Lineup& lineup : games.lineups()) names_.push_back(lineup.exam ? lineup.name : "");
}

void Exams::Add(int iteration, std::span<const GameResult> results) {
  std::unique_lock lock(mutex_);
  for (const GameResult& result : results) {
    const std::string& exam = names_.at(result.lineup);
    if (exam.empty()) continue;
    for (const Finish& finish : result.finishes) {
      if (!finish.counts) continue;
      rows_[{iteration, StrCat(finish.weights_version), exam}].Add(finish.outcome);
    }
  }
  const ScoreRows rows = rows_;
  lock.unlock();  // nobody waits for the disk
  file_.Write(rows);
}

std::vector<Exams::Row> Exams::Of(int iteration) const {
  const std::lock_guard lock(mutex_);
  std::map<std::string, MatchScore> scores;
  for (auto row = rows_.lower_bound({iteration, "", ""});
       row != rows_.end() && std::get<0>(row->first) == iteration; ++row) {
    scores[std::get<2>(row->first)] += row->second;
  }
  std::vector<Row> rows;
  for (const auto& [exam, score] : scores) rows.push_back({exam, score});
  return rows;
}

std::string Exams::CsvAfter(int iteration) const {
  const std::lock_guard lock(mutex_);
  return file_.TextOf({rows_.lower_bound({iteration + 1, "", ""}), rows_.end()});
}

}  // namespace powderkeg

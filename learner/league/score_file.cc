#include "learner/league/score_file.h"

#include <array>
#include <fstream>
#include <sstream>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/durable_file.h"
#include "common/base/number.h"

namespace powderkeg {

std::string ScoreFile::header() const {
  return StrCat("iteration,", first, ",", second, ",wins,ties,losses");
}

ScoreRows ScoreFile::Read(int iterations_done) const {
  ScoreRows rows;
  std::ifstream in(path);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (number == 1 && line == header()) continue;
    std::istringstream row(line);
    std::array<std::string, 6> cells;
    for (std::string& cell : cells) std::getline(row, cell, ',');
    const auto iteration = ParseNumber<int>(cells[0]);
    const auto wins = ParseNumber<std::uint64_t>(cells[3]);
    const auto ties = ParseNumber<std::uint64_t>(cells[4]);
    const auto losses = ParseNumber<std::uint64_t>(cells[5]);
    if (!iteration || !wins || !ties || !losses) {
      throw Error(StrCat(path.string(), ":", number, ": \"", line, "\"; expected ", header()));
    }
    if (*iteration <= iterations_done) {
      rows[{*iteration, cells[1], cells[2]}] += {*wins, *ties, *losses};
    }
  }
  return rows;
}

void ScoreFile::Write(const ScoreRows& rows) const {
  WriteFileDurably(path, BytesOf(TextOf(rows)));
}

std::string ScoreFile::TextOf(const ScoreRows& rows) const {
  std::ostringstream out;
  out << header() << '\n';
  for (const auto& [key, score] : rows) {
    const auto& [iteration, one, other] = key;
    out << iteration << ',' << one << ',' << other << ',' << score.wins << ',' << score.ties << ','
        << score.losses << '\n';
  }
  return out.str();
}

}  // namespace powderkeg

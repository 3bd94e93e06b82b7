#pragma once

// Results of games as a CSV that grows by iterations.

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <tuple>

#include "common/base/stats.h"

namespace powderkeg {

// By iteration and two names, which hold no comma; the score is the first one's.
using ScoreRows = std::map<std::tuple<int, std::string, std::string>, MatchScore>;

// Its columns are iteration, FIRST, SECOND, wins, ties and losses.
struct ScoreFile {
  std::filesystem::path path;
  std::string_view first;
  std::string_view second;

  [[nodiscard]] std::string header() const;
  // Nothing if there is no file. Rows of iterations later than `iterations_done`, which are now
  // repeated, are left out. Throws Error with the line.
  [[nodiscard]] ScoreRows Read(int iterations_done) const;
  // Durable when it returns. Throws Error.
  void Write(const ScoreRows& rows) const;
  [[nodiscard]] std::string TextOf(const ScoreRows& rows) const;
};

}  // namespace powderkeg

#pragma once

// What a contest says: for people, as JSON, and as CSV by agent and by game.

#include <array>
#include <optional>
#include <span>
#include <string>

#include "actors/arena/contest.h"
#include "actors/arena/match.h"
#include "actors/arena/summary.h"

namespace powderkeg {

// One measured agent of a report.
struct Contender {
  std::string agent;  // as specified
  std::string opponents;
  int simulations = 0;  // of its search per move; 0: it does not search
  Match match;
  std::optional<TestState> test;  // of the question about it
  MatchSummary summary;
  std::optional<Difference> difference;          // to the first contender; not of the first itself
  std::array<std::string, kAgentCount> roles{};  // who played each, as specified; empty: nobody
  bool teams = false;
  std::string settings{};  // where the agent plays with several models: what those share; or empty
};

// A block per contender; where there are several, a table with a line for each; for those that
// share `settings`, their mean with the spread between models, beside the interval of all their
// games together; and where more than two agents met, all of them by their rating.
[[nodiscard]] std::string ReportText(std::span<const Contender> contenders);

// One JSON object, {"contenders": [{"agent": ..., FIGURE: NUMBER, ..., "heat_map": [[row 0], ...]},
// ...]}; a contender with a question has "question", "answer" ("open" or a number as text) and
// "log_likelihood_ratio" too, and one among several models its "settings". The figures are the
// columns of TableCsv. Rates are 0 to 1, intervals 95 %; null stands for what is infinite or was
// not measured.
[[nodiscard]] std::string ReportJson(std::span<const Contender> contenders);

// One line per contender: its number, the series it belongs to (the number of the first contender
// that differs in simulations alone), every figure, cell_0 to cell_120 (row by row), and in the end
// agent and opponents in quotes. Empty: infinite or not measured. deploy/plot-arena draws it.
[[nodiscard]] std::string TableCsv(std::span<const Contender> contenders);

// One line per contender and game; the acts are those of role 0.
[[nodiscard]] std::string GamesCsv(std::span<const Contender> contenders);

}  // namespace powderkeg

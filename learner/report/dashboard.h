#pragma once

// A run as it looks in a browser, and what the page and other programs ask for.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/http/http_server.h"
#include "learner/report/run_view.h"

namespace powderkeg {

// Where it all comes from: called by several threads at once, they must not wait for long.
struct DashboardSources {
  std::function<RunView()> view;
  std::function<std::string(int after)> iterations;  // IterationHistory::CsvAfter
  std::function<std::string(int after)> exams;       // Exams::CsvAfter
  std::function<std::string()> ratings;              // League::RatingsCsv
};

// The text of dashboard.html: it needs nothing but the routes below.
extern const char* const kDashboardPage;

//   GET /                        the page
//   GET /figures.tsv             FiguresText: what there is to see
//   GET /status.json             status_json.h
//   GET /iterations.csv?after=N  the rows of iterations later than N (0: all)
//   GET /exams.csv?after=N       the same of exams
//   GET /ratings.csv             who is how strong
//   GET /metrics                 metrics.h
// Nothing of the run can be changed.
[[nodiscard]] std::vector<HttpRoute> DashboardRoutes(const DashboardSources& sources);

// Where to serve it: ADDRESS:PORT, auto (127.0.0.1:8265 or, where that is taken, any free port) or
// off (nullopt). Throws Error on any other text.
[[nodiscard]] std::optional<HttpServerSettings> DashboardServer(const std::string& text);

}  // namespace powderkeg

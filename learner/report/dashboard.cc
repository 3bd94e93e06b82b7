#include "learner/report/dashboard.h"

#include <charconv>
#include <string>

#include "common/base/check.h"
#include "learner/report/figures.h"
#include "learner/report/metrics.h"
#include "learner/report/status_json.h"

namespace powderkeg {
namespace {

HttpReply Iterations(const HttpRequest& request, const IterationHistory& history) {
  int after = 0;
  if (const auto found = request.parameters.find("after"); found != request.parameters.end()) {
    const std::string& text = found->second;
    const char* const text_end = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), text_end, after);
    if (error != std::errc() || end != text_end) {
      return HttpError(400, StrCat("after is '", text, "', expected the number of an iteration"));
    }
  }
  return {.body = history.CsvAfter(after), .type = "text/csv; charset=utf-8"};
}

}  // namespace

std::vector<HttpRoute> DashboardRoutes(const std::function<RunView()>& view,
                                       const IterationHistory& history) {
  return {
      {"GET", "/",
       [](const HttpRequest&) {
         return HttpReply{.body = kDashboardPage, .type = "text/html; charset=utf-8"};
       }},
      {"GET", "/figures.tsv",
       [](const HttpRequest&) {
         return HttpReply{.body = FiguresText(), .type = "text/tab-separated-values"};
       }},
      {"GET", "/status.json",
       [view](const HttpRequest&) { return HttpReply{.body = StatusJson(view())}; }},
      {"GET", "/iterations.csv",
       [&history](const HttpRequest& request) { return Iterations(request, history); }},
      {"GET", "/metrics",
       [view](const HttpRequest&) {
         return HttpReply{.body = MetricsText(view()), .type = kMetricsType};
       }},
  };
}

}  // namespace powderkeg

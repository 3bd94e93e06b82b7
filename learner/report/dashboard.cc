#include "learner/report/dashboard.h"

#include <chrono>
#include <string>

#include "common/base/check.h"
#include "common/base/number.h"
#include "learner/report/figures.h"
#include "learner/report/metrics.h"
#include "learner/report/status_json.h"

namespace powderkeg {
namespace {

const HttpAddress kUsualAddress{.host = "127.0.0.1", .port = 8265};

constexpr const char* kCsv = "text/csv; charset=utf-8";

HttpReply RowsAfter(const HttpRequest& request, const std::function<std::string(int)>& rows) {
  int after = 0;
  if (const auto found = request.parameters.find("after"); found != request.parameters.end()) {
    const auto number = ParseNumber<int>(found->second);
    if (!number) {
      return HttpError(
          400, StrCat("after is '", found->second, "', expected the number of an iteration"));
    }
    after = *number;
  }
  return {.body = rows(after), .type = kCsv};
}

}  // namespace

std::vector<HttpRoute> DashboardRoutes(const DashboardSources& sources) {
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
       [view = sources.view](const HttpRequest&) { return HttpReply{.body = StatusJson(view())}; }},
      {"GET", "/iterations.csv",
       [rows = sources.iterations](const HttpRequest& request) {
         return RowsAfter(request, rows);
       }},
      {"GET", "/exams.csv",
       [rows = sources.exams](const HttpRequest& request) { return RowsAfter(request, rows); }},
      {"GET", "/ratings.csv",
       [ratings = sources.ratings](const HttpRequest&) {
         return HttpReply{.body = ratings(), .type = kCsv};
       }},
      {"GET", "/metrics",
       [view = sources.view](const HttpRequest&) {
         return HttpReply{.body = MetricsText(view()), .type = kMetricsType};
       }},
  };
}

std::optional<HttpServerSettings> DashboardServer(const std::string& text) {
  if (text == "off") return std::nullopt;
  const auto address = text == "auto" ? kUsualAddress : ParseHttpAddress(text);
  if (!address) {
    throw Error(StrCat("--http is '", text,
                       "', expected ADDRESS:PORT with a port from 0 to 65535, auto or off"));
  }
  HttpServerSettings settings;
  settings.address = *address;
  settings.any_port_if_taken = text == "auto";
  settings.threads = 4;
  settings.max_waiting = 64;
  settings.max_request_bytes = 1024;
  settings.io_timeout = std::chrono::milliseconds(5000);
  return settings;
}

}  // namespace powderkeg

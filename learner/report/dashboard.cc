#include "learner/report/dashboard.h"

#include <charconv>
#include <chrono>
#include <string>

#include "common/base/check.h"
#include "learner/report/figures.h"
#include "learner/report/metrics.h"
#include "learner/report/status_json.h"

namespace powderkeg {
namespace {

const HttpAddress kUsualAddress{.host = "127.0.0.1", .port = 8265};

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

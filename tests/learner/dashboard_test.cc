#include "learner/report/dashboard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/check.h"
#include "learner/report/iteration_history.h"
#include "tests/http/raw_socket.h"
#include "tests/learner/record_support.h"
#include "tests/learner/view_support.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

class DashboardTest : public testing::Test {
 protected:
  DashboardTest() : history_(folder_.path() / "iterations.csv", 0) {
    for (int iteration = 1; iteration <= 3; ++iteration) history_.Append(ReportOf(iteration));
    server_ = std::make_unique<HttpServer>(
        DashboardRoutes({.view = PlayingRun,
                         .iterations = [this](int after) { return history_.CsvAfter(after); },
                         .exams = [](int after) { return StrCat("exams after ", after); },
                         .ratings = [] { return std::string("ratings"); }}),
        HttpServerSettings{
            .threads = 2, .max_request_bytes = 1024, .io_timeout = milliseconds(500)});
  }

  [[nodiscard]] int port() const { return server_->address().port; }
  [[nodiscard]] httplib::Result Get(const std::string& path) const {
    return httplib::Client("127.0.0.1", port()).Get(path);
  }

  const TemporaryFolder folder_;
  IterationHistory history_;
  std::unique_ptr<HttpServer> server_;
};

TEST_F(DashboardTest, ServesThePage) {
  const auto page = Get("/");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, 200);
  EXPECT_EQ(page->get_header_value("Content-Type"), "text/html; charset=utf-8");
  EXPECT_EQ(page->body, kDashboardPage);
  EXPECT_TRUE(page->body.starts_with("<!doctype html>"));
  EXPECT_TRUE(page->body.ends_with("</html>\n"));
}

TEST_F(DashboardTest, ServesFiguresStatusAndMetrics) {
  const auto figures = Get("/figures.tsv");
  ASSERT_TRUE(figures);
  EXPECT_EQ(figures->get_header_value("Content-Type"), "text/tab-separated-values");
  EXPECT_EQ(figures->body, FiguresText());
  const auto status = Get("/status.json");
  ASSERT_TRUE(status);
  EXPECT_EQ(status->get_header_value("Content-Type"), "application/json");
  EXPECT_EQ(nlohmann::json::parse(status->body)["run"], "quick");
  const auto metrics = Get("/metrics");
  ASSERT_TRUE(metrics);
  EXPECT_EQ(metrics->get_header_value("Content-Type"), "text/plain; version=0.0.4; charset=utf-8");
  EXPECT_THAT(metrics->body, HasSubstr("\npowderkeg_games_total 22\n"));
}

TEST_F(DashboardTest, ServesTheIterationsThatSomebodyLacks) {
  const auto all = Get("/iterations.csv");
  ASSERT_TRUE(all);
  EXPECT_EQ(all->get_header_value("Content-Type"), "text/csv; charset=utf-8");
  EXPECT_EQ(all->body, history_.CsvAfter(0));
  EXPECT_EQ(Get("/iterations.csv?after=2")->body, history_.CsvAfter(2));
  EXPECT_EQ(Get("/iterations.csv?after=3")->body, history_.CsvAfter(3));
  EXPECT_EQ(std::ranges::count(history_.CsvAfter(3), '\n'), 1) << "the header alone";
  for (const char* after : {"", "x", "1x", "1.5", "99999999999", "%ff"}) {
    const auto refused = Get(std::string("/iterations.csv?after=") + after);
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused->status, 400) << after;
    EXPECT_THAT(refused->body, HasSubstr("expected the number of an iteration"));
  }
}

TEST_F(DashboardTest, ServesExamsAndRatings) {
  EXPECT_EQ(Get("/exams.csv")->body, "exams after 0");
  EXPECT_EQ(Get("/exams.csv?after=2")->body, "exams after 2");
  EXPECT_EQ(Get("/exams.csv?after=x")->status, 400);
  EXPECT_EQ(Get("/ratings.csv")->body, "ratings");
}

TEST_F(DashboardTest, AThousandIterationsArriveWhole) {
  for (int iteration = 4; iteration <= 1000; ++iteration) history_.Append(ReportOf(iteration));
  const auto all = Get("/iterations.csv");
  ASSERT_TRUE(all);
  EXPECT_EQ(std::ranges::count(all->body, '\n'), 1001);
}

TEST_F(DashboardTest, CanOnlyBeRead) {
  httplib::Client client("127.0.0.1", port());
  EXPECT_EQ(client.Get("/x")->status, 404);
  EXPECT_EQ(client.Get("/index.html")->status, 404);
  EXPECT_EQ(client.Get("/../run_id")->status, 404);
  for (const char* path : {"/", "/figures.tsv", "/status.json", "/iterations.csv", "/metrics"}) {
    EXPECT_EQ(client.Post(path, "x", "text/plain")->status, 405) << path;
    EXPECT_EQ(client.Put(path, "x", "text/plain")->status, 405) << path;
    EXPECT_EQ(client.Delete(path)->status, 405) << path;
  }
  const auto refused = client.Post("/", "x", "text/plain");
  EXPECT_EQ(refused->body, R"({"error":"expected the method GET"})");
}

TEST_F(DashboardTest, HugeRequestsAndNonsenseEnd) {
  (void)ExchangeBytes(port(), "GET /" + std::string(10'000'000, 'x') + " HTTP/1.1\r\n\r\n");
  (void)ExchangeBytes(port(), "GET / HTTP/1.1\r\nX: " + std::string(10'000'000, 'x'));
  (void)ExchangeBytes(port(), "POST / HTTP/1.1\r\nContent-Length: 9999999999\r\n\r\n" +
                                  std::string(10'000'000, 'x'));
  (void)ExchangeBytes(port(), std::string(1000, '\0'));
  EXPECT_EQ(Get("/")->status, 200);
}

TEST_F(DashboardTest, SilentClientsHoldItForAWhileOnly) {
  std::vector<int> silent;
  for (int i = 0; i < 4; ++i) silent.push_back(ConnectTo(port()));  // twice its threads
  const auto page = Get("/");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, 200);
  for (const int socket : silent) EXPECT_EQ(ReadToEnd(socket), "");
}

TEST(DashboardServer, IsWhatTheOptionSays) {
  EXPECT_FALSE(DashboardServer("off"));
  EXPECT_EQ(DashboardServer("auto")->address.port, 8265);
  EXPECT_TRUE(DashboardServer("auto")->any_port_if_taken);
  EXPECT_EQ(DashboardServer("127.0.0.1:99")->address.port, 99);
  EXPECT_FALSE(DashboardServer("127.0.0.1:99")->any_port_if_taken);
  EXPECT_THROW((void)DashboardServer("8265"), Error);
}

// --- The page -----------------------------------------------------------------------------------

TEST(DashboardPage, RefersToNothingElsewhere) {
  const std::string page = kDashboardPage;
  EXPECT_THAT(page, Not(ContainsRegex(R"re([a-z]+://|["'(=] *//|@import|src *=|url\()re")));
  EXPECT_THAT(page, HasSubstr("default-src 'none'; connect-src 'self'"));
}

}  // namespace
}  // namespace powderkeg

#include "common/http/http_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "actors/http/agent_routes.h"
#include "actors/play/factory.h"
#include "actors/play/parallel_evaluator.h"
#include "actors/runner/runner_json.h"
#include "common/base/check.h"
#include "common/model/evaluation_cache.h"
#include "common/pommerman/generate.h"
#include "tests/http/gated_evaluator.h"
#include "tests/http/official_runner.h"
#include "tests/http/raw_socket.h"
#include "tests/http/scripted_agent.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

// An agent on a free port.
struct Seat {
  std::unique_ptr<AgentService> service;
  std::unique_ptr<HttpServer> server;
};

Seat SeatFor(std::string_view agent, const ServiceSettings& settings = {},
             const std::shared_ptr<Evaluator>& evaluator = std::make_shared<UniformEvaluator>()) {
  Seat seat;
  seat.service = std::make_unique<AgentService>(MakeAgent(ParseAgent(agent)), evaluator, settings);
  seat.server = std::make_unique<HttpServer>(AgentRoutes(*seat.service), HttpServerSettings{});
  return seat;
}

// --- Whole games --------------------------------------------------------------------------------

struct PlayedEnvironment {
  std::string name;
  std::string environment;
  std::array<std::string, 4> agents;
};

class WholeGameTest : public ::testing::TestWithParam<PlayedEnvironment> {};

TEST_P(WholeGameTest, EveryRequestIsAnsweredWithAnAction) {
  std::array<Seat, kAgentCount> seats;
  std::array<int, kAgentCount> ports{};
  for (std::size_t i = 0; i < seats.size(); ++i) {
    seats[i] = SeatFor(GetParam().agents[i]);
    ports[i] = seats[i].server->address().port;
  }
  const GameSettings settings = GameSettingsFor(GetParam().environment).value();
  OfficialRunner runner(settings, ports);
  const GameReport report = runner.PlayGame(/*seed=*/1, /*max_steps=*/200);
  EXPECT_EQ(report.failure, "");
  EXPECT_GT(report.steps, 10);
  const GameReport second = runner.PlayGame(/*seed=*/2, /*max_steps=*/50);
  EXPECT_EQ(second.failure, "") << "a second game without /init_agent";
  runner.Close();
  for (const Seat& seat : seats) {
    EXPECT_EQ(seat.service->statistics().games, 2U);
    EXPECT_EQ(seat.service->statistics().refused, 0U);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Environments, WholeGameTest,
    ::testing::Values(
        PlayedEnvironment{"FreeForAll",
                          "PommeFFACompetition-v0",
                          {"simple_unbiased", "official_simple", "harmless", "random"}},
        PlayedEnvironment{"Collapsing",
                          "PommeFFA-v1",
                          {"simple_unbiased", "simple_unbiased", "idle", "harmless"}},
        PlayedEnvironment{"Team",
                          "PommeTeamCompetition-v0",
                          {"official_simple", "simple_unbiased", "official_simple", "harmless"}},
        PlayedEnvironment{"Radio",
                          "PommeRadioCompetition-v2",
                          {"simple_unbiased", "harmless", "simple_unbiased", "idle"}}),
    [](const auto& environment) { return environment.param.name; });

TEST(WholeGameTest, SearchAgentsPlayLegalMoves) {
  std::array<Seat, kAgentCount> seats;
  std::array<int, kAgentCount> ports{};
  for (std::size_t i = 0; i < seats.size(); ++i) {
    seats[i] = SeatFor(i == 0 ? "search:simulations=20" : "harmless");
    ports[i] = seats[i].server->address().port;
  }
  OfficialRunner runner(GameSettings{}, ports);
  runner.RequireLegal(0);
  const GameReport report = runner.PlayGame(/*seed=*/4, /*max_steps=*/60);
  EXPECT_EQ(report.failure, "");
  runner.Close();
}

TEST(WholeGameTest, ASearchUnderAClockAnswersInTime) {
  std::array<Seat, kAgentCount> seats;
  std::array<int, kAgentCount> ports{};
  for (std::size_t i = 0; i < seats.size(); ++i) {
    seats[i] = i == 0 ? SeatFor("search:simulations=20000", {.move_time = milliseconds(10)})
                      : SeatFor("harmless");
    ports[i] = seats[i].server->address().port;
  }
  OfficialRunner runner(GameSettings{}, ports);
  runner.RequireLegal(0);
  const GameReport report = runner.PlayGame(/*seed=*/5, /*max_steps=*/20);
  EXPECT_EQ(report.failure, "");
  EXPECT_LT(seats[0].service->statistics().slowest_move.total(), milliseconds(1000));
}

// Something that keeps a core busy.
void Search(const std::stop_token& stop) {
  AgentService service(MakeAgent(ParseAgent("search:simulations=50")),
                       std::make_shared<UniformEvaluator>(), {});
  (void)service.InitAgent(InitBody(0, Mode::kFreeForAll));
  const State state = GenerateStart(GameSettings{}, {}, Rng(1));
  const std::string body = ActionBody(GameSettings{}, Observe(GameSettings{}, state, 0));
  while (!stop.stop_requested()) EXPECT_EQ(service.Act(body).status, 200);
}

TEST(WholeGameTest, TwoServersAnswerEveryRequestBesideABusyProgram) {
  const std::jthread load(Search);
  const auto play = [](std::uint64_t seed) {
    std::vector<std::unique_ptr<Evaluator>> threads;
    for (int i = 0; i < 2; ++i) threads.push_back(std::make_unique<UniformEvaluator>());
    const auto evaluator = std::make_shared<EvaluationCache>(
        std::make_unique<ParallelEvaluator>(std::move(threads)), 1 << 20);
    std::array<Seat, kAgentCount> seats;
    std::array<int, kAgentCount> ports{};
    for (std::size_t i = 0; i < seats.size(); ++i) {
      seats[i] = i == 0 ? SeatFor("search:simulations=20000,leaves_per_batch=8",
                                  {.move_time = milliseconds(10)}, evaluator)
                        : SeatFor("harmless");
      ports[i] = seats[i].server->address().port;
    }
    seats[0].service->WarmUp();
    OfficialRunner runner(GameSettings{}, ports);
    runner.RequireLegal(0);
    EXPECT_EQ(runner.PlayGame(seed, /*max_steps=*/15).failure, "");
    runner.Close();
    EXPECT_EQ(seats[0].service->statistics().refused, 0U);
    EXPECT_GT(seats[0].service->statistics().moves, 0U);  // how long it lives hangs on the clock
  };
  const std::jthread other([&play] { play(6); });
  play(7);
}

// --- Requests that are refused ------------------------------------------------------------------

class HttpServerTest : public ::testing::Test {
 protected:
  void Listen(const HttpServerSettings& settings) {
    service_ =
        std::make_unique<AgentService>(std::make_unique<ScriptedAgent>(diary_, 0),
                                       std::make_shared<UniformEvaluator>(), ServiceSettings{});
    server_ = std::make_unique<HttpServer>(AgentRoutes(*service_), settings);
  }
  void SetUp() override { Listen({}); }

  httplib::Client Client() const { return httplib::Client("127.0.0.1", server_->address().port); }
  static std::string Action() {
    const State state = GenerateStart(GameSettings{}, {}, Rng(1));
    return ActionBody(GameSettings{}, Observe(GameSettings{}, state, 0));
  }
  // Sends bytes as they are, ends the sending side and returns all that comes back.
  std::string Exchange(const std::string& bytes) const {
    return ExchangeBytes(server_->address().port, bytes);
  }

  AgentDiary diary_;
  std::unique_ptr<AgentService> service_;
  std::unique_ptr<HttpServer> server_;
};

TEST_F(HttpServerTest, RefusesWithStatusAndReason) {
  struct Case {
    std::string method, path, body;
    int status;
    std::string reason;
  };
  const std::vector<Case> cases = {
      {"GET", "/", "", 404, "no such route"},
      {"POST", "/nothing", "{}", 404, "no such route"},
      {"DELETE", "/action", "", 405, "expected the method POST"},
      {"POST", "/ping", "{}", 405, "expected the method GET"},
      {"GET", "/action", "", 405, "expected the method POST"},
      {"POST", "/action", "", 400, "the body is no JSON text"},
      {"POST", "/action", "{}", 400, "the key obs is missing"},
      {"POST", "/action", Action(), 409, "before /init_agent"},
      {"POST", "/episode_end", R"({"reward": "0"})", 409, "before /init_agent"},
      {"POST", "/init_agent", R"({"id": "9", "game_type": "1"})", 400, "id is 9"},
      {"POST", "/init_agent", std::string(100'000, '['), 413, "too long"},
      {"POST", "/nothing", std::string(100'000, ' '), 404, "no such route"},
  };
  for (const Case& test : cases) {
    httplib::Request request;
    request.method = test.method;
    request.path = test.path;
    request.body = test.body;
    if (test.method == "POST") request.set_header("Content-Type", "application/json");
    auto client = Client();
    const auto result = client.send(request);
    ASSERT_TRUE(result) << test.method << " " << test.path << " " << to_string(result.error());
    EXPECT_EQ(result->status, test.status) << test.method << " " << test.path;
    EXPECT_THAT(result->body, HasSubstr(test.reason)) << test.method << " " << test.path;
    EXPECT_TRUE(nlohmann::json::parse(result->body).contains("error"));
    EXPECT_EQ(result->body.find('\n'), std::string::npos);
  }
}

// The clock of a move starts when the request is there, not when a thread gets to it, and a client
// cannot set it.
TEST_F(HttpServerTest, AMoveBeginsWithTheArrivalOfItsRequest) {
  (void)service_->InitAgent(InitBody(0, Mode::kFreeForAll));
  httplib::Headers headers = {{"Powderkeg-Arrival", "1"}};
  const auto result = Client().Post("/action", headers, Action(), "application/json");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 200);
  EXPECT_LT(service_->statistics().slowest_move.total(), std::chrono::seconds(60));
}

TEST(HttpServerOfASearch, AnEvaluatorThatFailsIsReportedAndTheServerGoesOn) {
  const auto evaluator = std::make_shared<GatedEvaluator>();
  const Seat seat = SeatFor("search:simulations=20", {}, evaluator);
  (void)seat.service->InitAgent(InitBody(0, Mode::kFreeForAll));
  evaluator->FailAfter(1, std::make_exception_ptr(Error("the device is lost")));
  const State state = GenerateStart(GameSettings{}, {}, Rng(1));
  const std::string body = ActionBody(GameSettings{}, Observe(GameSettings{}, state, 0));
  httplib::Client client("127.0.0.1", seat.server->address().port);
  const auto failed = client.Post("/action", body, "application/json");
  ASSERT_TRUE(failed);
  EXPECT_EQ(failed->status, 500);
  EXPECT_EQ(failed->body, R"({"error":"the device is lost"})");
  const auto result = client.Post("/action", body, "application/json");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 200);
}

TEST_F(HttpServerTest, SurvivesWhatIsNoHttp) {
  EXPECT_THAT(Exchange("nonsense\r\n\r\n"), HasSubstr("400"));
  (void)Exchange(std::string(100'000, 'x'));
  (void)Exchange("\r\n\r\n");
  (void)Exchange("");
  (void)Exchange(std::string(1000, '\0'));
  (void)Exchange("POST /action HTTP/1.1\r\nContent-Length: 99999999999999999999\r\n\r\n{}");
  (void)Exchange("POST /action HTTP/1.1\r\nContent-Length: -1\r\n\r\n{}");
  (void)Exchange("POST /action HTTP/1.1\r\nContent-Length: 50\r\n\r\n{}");
  (void)Exchange("POST /action HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nFFFFFFFFFFFF\r\n");
  (void)Exchange(
      "POST /action HTTP/1.1\r\nContent-Type: multipart/form-data; boundary=x\r\n"
      "Content-Length: 4\r\n\r\n--x\r");
  EXPECT_EQ(Client().Get("/ping")->status, 200);
}

TEST_F(HttpServerTest, EndsEndlessHeadersAndBodies) {
  std::string headers = "GET /ping HTTP/1.1\r\n";
  while (headers.size() < 10'000'000) headers += "X: " + std::string(1000, 'x') + "\r\n";
  (void)Exchange(headers);
  std::string chunks = "POST /action HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n";
  while (chunks.size() < 10'000'000) chunks += "1000\r\n" + std::string(0x1000, ' ') + "\r\n";
  (void)Exchange(chunks);
  EXPECT_EQ(Client().Get("/ping")->status, 200);
}

TEST_F(HttpServerTest, ABodyThatUnpacksToTooMuchIsRefused) {
  auto client = Client();
  client.set_compress(true);
  const auto result = client.Post("/action", std::string(10'000'000, ' '), "application/json");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 413);
}

TEST_F(HttpServerTest, CompressedBodiesAreRead) {
  auto client = Client();
  client.set_compress(true);
  EXPECT_EQ(client.Post("/init_agent", InitBody(0, Mode::kFreeForAll), "application/json")->status,
            200);
}

TEST_F(HttpServerTest, APortIsServedOnce) {
  EXPECT_THROW(Listen({.address = server_->address()}), Error);
  EXPECT_THROW(Listen({.address = {.host = "no.such.host.invalid"}}), Error);
  EXPECT_EQ(Client().Get("/ping")->status, 200);
}

TEST_F(HttpServerTest, APortIsFreeAgainAfterTheServer) {
  const HttpAddress address = server_->address();
  EXPECT_EQ(Client().Get("/ping")->status, 200);
  server_.reset();
  Listen({.address = address});
  EXPECT_EQ(Client().Get("/ping")->status, 200);
}

TEST_F(HttpServerTest, AnotherPortIsServedWhereOneIsTakenIfThatIsAllowed) {
  const int taken = server_->address().port;
  const HttpServer other(AgentRoutes(*service_),
                         {.address = server_->address(), .any_port_if_taken = true});
  EXPECT_NE(other.address().port, taken);
  EXPECT_EQ(httplib::Client("127.0.0.1", other.address().port).Get("/ping")->status, 200);
  EXPECT_THROW(HttpServer({}, {.address = {.host = "no.such.host.invalid", .port = taken},
                               .any_port_if_taken = true}),
               Error);
}

TEST(HttpAddress, IsReadAndWritten) {
  EXPECT_EQ(ParseHttpAddress("127.0.0.1:8265"), (HttpAddress{.host = "127.0.0.1", .port = 8265}));
  EXPECT_EQ(ParseHttpAddress("localhost:0"), (HttpAddress{.host = "localhost", .port = 0}));
  EXPECT_EQ(ParseHttpAddress("[::1]:65535"), (HttpAddress{.host = "::1", .port = 65535}));
  for (const char* text : {"", ":", ":80", "foo", "8265", "foo:", "foo:x", "foo:80x", "foo:-1",
                           "foo:65536", "foo:99999999999999999999", "foo: 80"}) {
    EXPECT_EQ(ParseHttpAddress(text), std::nullopt) << text;
  }
  EXPECT_EQ((HttpAddress{.host = "127.0.0.1", .port = 8265}.url()), "http://127.0.0.1:8265/");
  EXPECT_EQ((HttpAddress{.host = "::1", .port = 1}.url()), "http://[::1]:1/");
}

// --- Routes that are not an agent's -------------------------------------------------------------

TEST(HttpServerOfRoutes, AGetAnswersWithItsTypeAndKnowsItsParameters) {
  const HttpServer server({{"GET", "/page.html",
                            [](const HttpRequest& request) {
                              return HttpReply{.body = request.parameters.at("after"),
                                               .type = "text/html"};
                            }}},
                          {});
  httplib::Client client("127.0.0.1", server.address().port);
  const auto result = client.Get("/page.html?after=%3C3&after=4&x");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 200);
  EXPECT_EQ(result->body, "<3");
  EXPECT_EQ(result->get_header_value("Content-Type"), "text/html");
  EXPECT_EQ(client.Get("/page.html")->status, 500) << "an exception of the route";
  EXPECT_EQ(client.Get("/pagexhtml")->status, 404) << "a path is no pattern";
  EXPECT_EQ(client.Post("/page.html")->get_header_value("Allow"), "GET");
}

constexpr std::size_t kLongAnswer = 32 << 20;

HttpRoute LongAnswer() {
  return {"GET", "/", [](const HttpRequest&) {
            return HttpReply{.body = std::string(kLongAnswer, 'x'), .type = "image/x"};
          }};
}

TEST(HttpServerOfRoutes, ALongAnswerArrivesWhole) {
  const HttpServer server({LongAnswer()}, {.io_timeout = std::chrono::seconds(60)});
  const std::string answer = ExchangeBytes(server.address().port, "GET / HTTP/1.1\r\n\r\n");
  EXPECT_EQ(answer.size(), answer.find("\r\n\r\n") + 4 + kLongAnswer);
}

// Reads a byte now and then, so that each single write makes progress.
void Sip(int socket, const std::stop_token& stop) {
  std::array<char, 1024> some{};
  while (!stop.stop_requested() && ::recv(socket, some.data(), some.size(), 0) > 0) {
    std::this_thread::sleep_for(milliseconds(1));
  }
}

TEST(HttpServerOfRoutes, AClientThatReadsSlowlyHoldsAThreadForAWhileOnly) {
  const HttpServer server({LongAnswer(), {"GET", "/ping", [](auto&&) { return HttpReply{}; }}},
                          {.threads = 1, .io_timeout = milliseconds(100)});
  const int slow = ConnectTo(server.address().port);
  SendAll(slow, "GET / HTTP/1.1\r\n\r\n");
  std::jthread sipping([slow](const std::stop_token& stop) { Sip(slow, stop); });
  httplib::Client client("127.0.0.1", server.address().port);
  const auto result = client.Get("/ping");
  ASSERT_TRUE(result) << "the only thread is held";
  EXPECT_EQ(result->status, 200);
  sipping = {};
  (void)ReadToEnd(slow);
}

TEST(HttpServerOfRoutes, ARequestArrivesWhenItIsThereAndNotWhenAThreadIs) {
  std::atomic<bool> held = false;
  std::atomic<milliseconds> waited{};
  const HttpServer server({{"GET", "/hold",
                            [&](const HttpRequest&) {
                              held = true;
                              std::this_thread::sleep_for(milliseconds(200));
                              return HttpReply{};
                            }},
                           {"GET", "/next",
                            [&](const HttpRequest& request) {
                              waited = std::chrono::duration_cast<milliseconds>(
                                  std::chrono::steady_clock::now() - request.arrival);
                              return HttpReply{};
                            }}},
                          {.threads = 1});
  const int port = server.address().port;
  const std::jthread other([port] { (void)ExchangeBytes(port, "GET /hold HTTP/1.1\r\n\r\n"); });
  while (!held) std::this_thread::yield();
  (void)ExchangeBytes(port, "GET /next HTTP/1.1\r\n\r\n");
  EXPECT_GT(waited.load(), milliseconds(50));
}

// --- What keeps a connection open ---------------------------------------------------------------

HttpRoute Ping() {
  return {"GET", "/ping", [](const HttpRequest&) { return HttpReply{.body = "pong"}; }};
}

TEST(HttpServerOfRoutes, NoThreadWaitsForRequestsNorForThoseWhoHaveTheirAnswer) {
  const std::vector<std::string> beginnings = {
      "",
      "G",
      "GET /ping HTTP/1.1\r\n",
      "GET /ping HTTP/1.1\r\n\r\n",  // answered, and the connection kept
      "POST /ping HTTP/1.1\r\nContent-Length: 40000\r\n\r\n{",
      "POST /ping HTTP/1.1\r\nContent-Length: +5\r\n\r\n{",
      "POST /ping HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n5\r\n",
  };
  for (const std::string& beginning : beginnings) {
    const HttpServer server({Ping()}, {.threads = 2, .io_timeout = std::chrono::seconds(30)});
    std::vector<int> sockets;
    for (int i = 0; i < 60; ++i) {
      sockets.push_back(ConnectTo(server.address().port));
      SendAll(sockets.back(), beginning);
    }
    httplib::Client client("127.0.0.1", server.address().port);
    client.set_read_timeout(std::chrono::seconds(5));
    const auto result = client.Get("/ping");
    ASSERT_TRUE(result) << beginning;
    EXPECT_EQ(result->body, "pong");
    for (const int socket : sockets) ::close(socket);
  }
}

TEST(HttpServerOfRoutes, ARequestMayComeInPieces) {
  const HttpServer server({Ping()}, {});
  const int socket = ConnectTo(server.address().port);
  for (const char byte : std::string("GET /ping HTTP/1.1\r\nX: y\r\n\r\n")) {
    SendAll(socket, std::string(1, byte));
  }
  EXPECT_THAT(ReadToEnd(socket), HasSubstr("pong"));
}

TEST(HttpServerOfRoutes, WhoeverWaitsLongestGoesWhenThereAreTooMany) {
  const HttpServer server({Ping()}, {.max_waiting = 10, .io_timeout = std::chrono::seconds(30)});
  std::vector<int> sockets;
  for (int i = 0; i < 11; ++i) sockets.push_back(ConnectTo(server.address().port));
  EXPECT_EQ(ReadToEnd(sockets.front()), "");
  SendAll(sockets.back(), "GET /ping HTTP/1.1\r\n\r\n");
  EXPECT_THAT(ReadToEnd(sockets.back()), HasSubstr("pong"));
  for (std::size_t i = 1; i < 10; ++i) ::close(sockets[i]);
}

TEST(HttpServerOfRoutes, PartsOfAnAnswerAreNotServed) {
  const HttpServer server({Ping()}, {});
  std::string ranges = "bytes=0-";
  for (int i = 0; i < 1000; ++i) ranges += ",0-";
  httplib::Client client("127.0.0.1", server.address().port);
  const auto result = client.Get("/ping", {{"Range", ranges}});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 200);
  EXPECT_EQ(result->body, "pong");
}

// --- Who asks -----------------------------------------------------------------------------------

TEST_F(HttpServerTest, PagesOfOthersAreRefused) {
  const auto status = [&](const httplib::Headers& headers, const char* type) {
    return Client().Post("/shutdown", headers, "{}", type)->status;
  };
  const std::string here = StrCat("127.0.0.1:", server_->address().port);
  EXPECT_EQ(status({}, "application/json"), 200) << "the official runner";
  EXPECT_EQ(status({{"Origin", "http://" + here}}, "application/json; charset=utf-8"), 200);
  EXPECT_EQ(status({}, "text/plain"), 415);
  EXPECT_EQ(status({}, "application/x-www-form-urlencoded"), 415);
  EXPECT_EQ(status({{"Origin", "http://example.com"}}, "application/json"), 403);
  EXPECT_EQ(status({{"Origin", "null"}}, "application/json"), 403);
  EXPECT_EQ(status({{"Host", "example.com"}, {"Origin", "http://example.com"}}, "application/json"),
            403);
}

TEST_F(HttpServerTest, IsReachedByNamesThatNoStrangerCanGive) {
  const auto status = [&](const std::string& host) {
    return Client().Get("/ping", {{"Host", host}})->status;
  };
  for (const char* host : {"localhost", "localhost:80", "127.0.0.1", "10.0.0.7:10080", "[::1]:80",
                           "agent-0:10080", ""}) {
    EXPECT_EQ(status(host), 200) << host;
  }
  for (const char* host : {"example.com", "example.com:10080", "127.0.0.1.example.com"}) {
    EXPECT_EQ(status(host), 403) << host;
  }
}

TEST_F(HttpServerTest, ATargetMayNameTheServer) {
  EXPECT_THAT(Exchange("GET http://127.0.0.1:80/ping HTTP/1.1\r\n\r\n"), HasSubstr(" 200 "));
  EXPECT_THAT(Exchange("GET http://127.0.0.1:80 HTTP/1.1\r\n\r\n"), HasSubstr(" 404 "));
}

TEST_F(HttpServerTest, AnAddressMayStandInBrackets) {
  try {
    Listen({.address = {.host = "::1"}});
  } catch (const Error&) {
    GTEST_SKIP() << "no IPv6 here";
  }
  Listen({.address = {.host = "[::1]"}});
  EXPECT_EQ(httplib::Client("::1", server_->address().port).Get("/ping")->status, 200);
}

// --- Many connections ---------------------------------------------------------------------------

// As many file descriptors as the system allows; the tests below need about 2,100.
void AllowManyConnections() {
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &limit), 0);
  limit.rlim_cur = limit.rlim_max;
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &limit), 0);
  if (limit.rlim_cur < 2500) GTEST_SKIP() << "only " << limit.rlim_cur << " file descriptors";
}

TEST_F(HttpServerTest, AThousandConnectionsAtOnceAreAllAnswered) {
  AllowManyConnections();
  (void)service_->InitAgent(InitBody(0, Mode::kFreeForAll));
  const std::string body = Action();
  const std::string request =
      StrCat("POST /action HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n",
             "Content-Length: ", body.size(), "\r\n\r\n", body);
  std::vector<int> sockets;
  for (int i = 0; i < 1000; ++i) sockets.push_back(ConnectTo(server_->address().port));
  for (const int socket : sockets) SendAll(socket, request);
  int answered = 0;
  for (const int socket : sockets) {
    if (ReadToEnd(socket).find(R"({"action":5})") != std::string::npos) ++answered;
  }
  EXPECT_EQ(answered, 1000);
  EXPECT_EQ(service_->statistics().moves, 1000U);
}

TEST_F(HttpServerTest, AThousandSilentConnectionsDoNotStopTheServer) {
  AllowManyConnections();
  Listen({.io_timeout = milliseconds(50)});
  std::vector<int> sockets;
  for (int i = 0; i < 1000; ++i) sockets.push_back(ConnectTo(server_->address().port));
  auto client = Client();
  client.set_read_timeout(std::chrono::seconds(60));
  const auto result = client.Get("/ping");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 200);
  for (const int socket : sockets) EXPECT_EQ(ReadToEnd(socket), "");
}

TEST_F(HttpServerTest, ConcurrentClientsOfOneAgentAreServedInTurn) {
  std::atomic<int> good = 0;
  std::vector<std::jthread> clients;
  for (int i = 0; i < 8; ++i) {
    clients.emplace_back([&] {
      for (int k = 0; k < 20; ++k) {
        auto client = Client();
        const auto init =
            client.Post("/init_agent", InitBody(0, Mode::kFreeForAll), "application/json");
        const auto action = client.Post("/action", Action(), "application/json");
        if (init && init->status == 200 && action && action->status == 200) ++good;
      }
    });
  }
  clients.clear();
  EXPECT_EQ(good, 160);
}

}  // namespace
}  // namespace powderkeg

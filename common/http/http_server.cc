#include "common/http/http_server.h"

#include <arpa/inet.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <functional>
#include <latch>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/bounded_queue.h"
#include "common/base/check.h"
#include "common/base/descriptors.h"
#include "common/base/log.h"
#include "common/base/unique.h"
#include "common/base/worker.h"
#include "common/http/socket_stream.h"
#include "common/http/waiting_room.h"

namespace powderkeg {
namespace {

constexpr int kBacklog = 1024;

// A fixed number of threads that take connections from a queue of limited length; where it is full,
// the caller waits.
class ConnectionPool {
 public:
  using Serve = std::function<void(int socket)>;

  ConnectionPool(int threads, std::size_t max_waiting, Serve serve)
      : serve_(std::move(serve)), waiting_(max_waiting) {
    for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { Run(); });
  }
  // Serves those that wait.
  ~ConnectionPool() { waiting_.Close(); }
  ConnectionPool(const ConnectionPool&) = delete;
  ConnectionPool& operator=(const ConnectionPool&) = delete;

  void Add(int socket) {
    while (waiting_.Push(std::move(socket), kPatience) == QueueResult::kTimedOut) {
    }
  }

 private:
  static constexpr std::chrono::milliseconds kPatience{1000};

  void Run() {
    while (!waiting_.drained()) {
      if (const auto socket = waiting_.Pop(kPatience)) serve_(*socket);
    }
  }

  Serve serve_;
  BoundedQueue<int> waiting_;
  std::vector<std::jthread> threads_;
};

// What the library does with a new connection: nothing that takes time.
class AtOnce final : public httplib::TaskQueue {
 public:
  void enqueue(std::function<void()> connection) override { connection(); }
  void shutdown() override {}
};

using Clock = std::chrono::steady_clock;

// The library hands on nothing of ours from the connection to the handler of its request but the
// request itself: the time is written into a header.
constexpr const char* kArrival = "Powderkeg-Arrival";

void SetArrival(Clock::time_point arrival, httplib::Request& request) {
  request.headers.erase(kArrival);
  request.set_header(kArrival, std::to_string(arrival.time_since_epoch().count()));
}

Clock::time_point ArrivalOf(const httplib::Request& request) {
  const std::string ticks = request.get_header_value(kArrival);
  return Clock::time_point(Clock::duration(std::stoll(ticks)));
}

// A proxy's form of a target, "http://127.0.0.1/ping", says no more than its path.
void StripAuthority(std::string& path) {
  constexpr std::string_view kScheme = "http://";
  if (path.starts_with(kScheme))
    path.erase(0, std::min(path.find('/', kScheme.size()), path.size()));
}

// The host of "HOST" or "HOST:PORT".
std::string HostOf(std::string_view authority) {
  const std::size_t colon = authority.rfind(':');
  const bool port =
      colon != std::string_view::npos && authority.find(']', colon) == std::string_view::npos;
  return std::string(WithoutBrackets(port ? authority.substr(0, colon) : authority));
}

// Whether a stranger can have given this machine the name, so that a page of theirs reaches servers
// on it (DNS rebinding). Names without a dot are of the local network.
bool IsForeign(const std::string& host, const std::string& own_name) {
  in6_addr number{};
  if (inet_pton(AF_INET, host.c_str(), &number) == 1) return false;
  if (inet_pton(AF_INET6, host.c_str(), &number) == 1) return false;
  const bool dot = host.find('.') != std::string::npos;
  return dot && host != own_name && !host.starts_with(HostName() + ".");
}

HttpRequest AsRequest(const httplib::Request& request, std::string body) {
  return {.body = std::move(body),
          .parameters = {request.params.begin(), request.params.end()},
          .arrival = ArrivalOf(request)};
}

void SetReply(const HttpReply& reply, httplib::Response& response) {
  response.status = reply.status;
  response.set_content(reply.body, reply.type);
}

void SetError(int status, std::string_view reason, httplib::Response& response) {
  SetReply(HttpError(status, reason), response);
}

// What httplib itself refuses has a status only.
void ExplainStatus(const httplib::Request&, httplib::Response& response) {
  if (!response.body.empty()) return;
  SetError(response.status,
           response.status == 413 ? "the body is too long" : "the request is no HTTP", response);
}

void ReportException(const httplib::Request&, httplib::Response& response,
                     const std::exception_ptr& exception) {
  try {
    std::rethrow_exception(exception);
  } catch (const std::exception& error) {
    log::Error("request failed", "reason", error.what());
    SetError(500, error.what(), response);
  }
}

}  // namespace

// The HTTP library, with limits of ours for each connection.
class HttpServer::Listener final : public httplib::Server {
 public:
  Listener(std::vector<HttpRoute> routes, const HttpServerSettings& settings)
      : routes_(std::move(routes)),
        settings_(settings),
        address_(settings.address),
        started_(1),
        pool_(std::in_place, settings.threads, settings.max_waiting,
              [this](int socket) { Serve(socket); }) {
    address_.host = WithoutBrackets(settings.address.host);
    const std::size_t room = std::min(settings.max_waiting, DescriptorLimit() / 4);
    room_.emplace(
        WaitingRoomSettings{
            .max_connections = room, .max_bytes = MaxBytes(), .timeout = settings.io_timeout},
        [this](int socket) { pool_->Add(socket); });
    AddRoutes();
    set_tcp_nodelay(true);
    set_payload_max_length(settings.max_request_bytes);
    // The library's default would let two servers share one port.
    set_socket_options([](socket_t socket) {
      const int yes = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
    });
    new_task_queue = [this] {
      started_.count_down();
      return new AtOnce;
    };
    if (!Bind()) {
      throw Error(StrCat("cannot listen on ", address_.host, ":", settings.address.port,
                         ", expected an address of this machine and a free port"));
    }
    ::listen(svr_sock_, kBacklog);  // instead of the library's 5
    worker_.emplace("http", [this](const std::stop_token&) { listen_after_bind(); });
    started_.wait();
  }
  ~Listener() override {
    stop();
    worker_->Join();
    room_->Close();
    pool_.reset();
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  [[nodiscard]] const HttpAddress& address() const { return address_; }

 private:
  // Whether it could.
  [[nodiscard]] bool Bind() {
    const std::string& host = address_.host;
    const int port = settings_.address.port;
    if (port != 0 && bind_to_port(host, port)) return true;
    if (port != 0 && !settings_.any_port_if_taken) return false;
    address_.port = bind_to_any_port(host);
    return address_.port >= 0;
  }

  void AddRoutes() {
    using Request = httplib::Request;
    using Response = httplib::Response;
    for (const HttpRoute& route : routes_) {
      if (route.method == "GET") {
        Get(route.path, [&route](const Request& request, Response& response) {
          SetReply(route.answer(AsRequest(request, {})), response);
        });
      } else {
        Post(route.path, [this, &route](const Request& request, Response& response,
                                        const httplib::ContentReader& reader) {
          AnswerPost(route, request, reader, response);
        });
      }
    }
    set_pre_routing_handler([this](const Request& request, Response& response) {
      return CheckRoute(request, response);
    });
    set_error_handler(ExplainStatus);
    set_exception_handler(ReportException);
  }

  // Refuses requests for anything but the routes before their bodies are read.
  HandlerResponse CheckRoute(const httplib::Request& request, httplib::Response& response) const {
    const auto route = std::ranges::find(routes_, request.path, &HttpRoute::path);
    if (route == routes_.end()) {
      SetError(404, "no such route, known are " + KnownPaths(), response);
      return HandlerResponse::Handled;
    }
    if (request.method != route->method) {
      response.set_header("Allow", route->method);
      SetError(405, "expected the method " + route->method, response);
      return HandlerResponse::Handled;
    }
    return CheckOrigin(request, response);
  }

  // Refuses what pages of others make a browser send.
  HandlerResponse CheckOrigin(const httplib::Request& request, httplib::Response& response) const {
    const std::string host = request.get_header_value("Host");
    const std::string origin = request.get_header_value("Origin");
    const std::string type = request.get_header_value("Content-Type");
    if (IsForeign(HostOf(host), address_.host)) {
      SetError(403, "the header Host is " + host + ", expected this machine's name or address",
               response);
    } else if (request.method == "POST" && !origin.empty() && origin != "http://" + host) {
      SetError(403, "the header Origin is " + origin + ", expected none or http://" + host,
               response);
    } else if (request.method == "POST" && !type.starts_with("application/json")) {
      SetError(415, "the header Content-Type is \"" + type + "\", expected application/json",
               response);
    } else {
      return HandlerResponse::Unhandled;
    }
    return HandlerResponse::Handled;
  }

  [[nodiscard]] std::string KnownPaths() const {
    std::string paths;
    for (const HttpRoute& route : routes_) paths += (paths.empty() ? "" : ", ") + route.path;
    return paths;
  }

  void AnswerPost(const HttpRoute& route, const httplib::Request& request,
                  const httplib::ContentReader& reader, httplib::Response& response) const {
    std::string body;
    if (!ReadBody(reader, body)) {
      return SetError(413, "the body is incomplete or too long", response);
    }
    SetReply(route.answer(AsRequest(request, std::move(body))), response);
  }

  // Bounds what a compressed body unpacks to as well.
  [[nodiscard]] bool ReadBody(const httplib::ContentReader& reader, std::string& body) const {
    return reader([&](const char* data, std::size_t size) {
      if (body.size() + size > settings_.max_request_bytes) return false;
      body.append(data, size);
      return true;
    });
  }

  bool process_and_close_socket(socket_t socket) override {
    room_->Admit(socket);
    return true;
  }

  // On a thread of the pool.
  void Serve(int socket) {
    {
      SocketStream stream(socket, {.max_bytes = MaxBytes(), .timeout = settings_.io_timeout});
      bool closed = false;
      process_request(stream, /*close_connection=*/true, closed,
                      [&stream](httplib::Request& request) {
                        SetArrival(stream.last_arrival(), request);
                        StripAuthority(request.path);
                        request.ranges.clear();  // a few bytes would ask for answers without end
                      });
    }
    room_->Dismiss(socket);
  }

  [[nodiscard]] std::size_t MaxBytes() const {
    constexpr std::size_t kHeaderBytes = 16 << 10;
    return settings_.max_request_bytes + kHeaderBytes;
  }

  const std::vector<HttpRoute> routes_;
  const HttpServerSettings settings_;
  HttpAddress address_;
  std::latch started_;
  std::optional<WaitingRoom> room_;  // hands connections to the pool, and gets them back
  std::optional<ConnectionPool> pool_;
  std::optional<Worker> worker_;
};

HttpReply HttpError(int status, std::string_view reason) {
  // Reasons quote what strangers sent.
  const auto handler = nlohmann::json::error_handler_t::replace;
  return {.status = status,
          .body = nlohmann::json{{"error", reason}}.dump(-1, ' ', false, handler)};
}

HttpServer::HttpServer(std::vector<HttpRoute> routes, const HttpServerSettings& settings)
    : listener_(std::make_unique<Listener>(std::move(routes), settings)) {}

HttpServer::~HttpServer() = default;

const HttpAddress& HttpServer::address() const { return listener_->address(); }

}  // namespace powderkeg

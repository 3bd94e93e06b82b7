#include "common/http/http_server.h"

#include <sys/socket.h>

#include <algorithm>
#include <charconv>
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
#include "common/base/log.h"
#include "common/base/worker.h"
#include "common/http/socket_stream.h"

namespace powderkeg {
namespace {

constexpr int kBacklog = 1024;

// A fixed number of threads that take connections from a queue of limited length; where it is full,
// the caller (who accepts connections) waits.
class ConnectionPool final : public httplib::TaskQueue {
 public:
  ConnectionPool(int threads, std::size_t max_waiting) : waiting_(max_waiting) {
    for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { Serve(); });
  }

  void enqueue(std::function<void()> connection) override {
    while (waiting_.Push(std::move(connection), kPatience) == QueueResult::kTimedOut) {
    }
  }
  void shutdown() override {
    waiting_.Close();
    threads_.clear();  // joins
  }

 private:
  static constexpr std::chrono::milliseconds kPatience{1000};

  void Serve() {
    while (!waiting_.drained()) {
      if (const auto connection = waiting_.Pop(kPatience)) (*connection)();
    }
  }

  BoundedQueue<std::function<void()>> waiting_;
  std::vector<std::jthread> threads_;
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
      : routes_(std::move(routes)), settings_(settings), address_(settings.address), started_(1) {
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
      return new ConnectionPool(settings_.threads, settings_.max_waiting);
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
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  [[nodiscard]] const HttpAddress& address() const { return address_; }

 private:
  // Whether it could.
  [[nodiscard]] bool Bind() {
    const auto& [host, port] = settings_.address;
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
    if (request.method == route->method) return HandlerResponse::Unhandled;
    response.set_header("Allow", route->method);
    SetError(405, "expected the method " + route->method, response);
    return HandlerResponse::Handled;
  }

  [[nodiscard]] std::string KnownPaths() const {
    std::string paths;
    for (const HttpRoute& route : routes_) paths += (paths.empty() ? "" : ", ") + route.path;
    return paths;
  }

  void AnswerPost(const HttpRoute& route, const httplib::Request& request,
                  const httplib::ContentReader& reader, httplib::Response& response) const {
    if (request.is_multipart_form_data()) {
      return SetError(415, "expected a body that is no form", response);
    }
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
    SocketStream stream(socket, {.max_bytes = settings_.max_request_bytes + kHeaderBytes,
                                 .timeout = settings_.io_timeout});
    bool closed = false;
    return process_request(
        stream, /*close_connection=*/true, closed,
        [&stream](httplib::Request& request) { SetArrival(stream.last_arrival(), request); });
  }

  static constexpr std::size_t kHeaderBytes = 16 << 10;

  const std::vector<HttpRoute> routes_;
  const HttpServerSettings settings_;
  HttpAddress address_;
  std::latch started_;
  std::optional<Worker> worker_;
};

std::string HttpAddress::url() const {
  const bool ipv6 = host.find(':') != std::string::npos;
  return StrCat("http://", ipv6 ? "[" + host + "]" : host, ":", port, "/");
}

std::optional<HttpAddress> ParseHttpAddress(std::string_view text) {
  constexpr int kHighestPort = 65535;
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return std::nullopt;
  std::string_view host = text.substr(0, colon);
  const std::string_view digits = text.substr(colon + 1);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  int port = -1;
  const auto [end, error] = std::from_chars(digits.begin(), digits.end(), port);
  const bool number = error == std::errc() && end == digits.end();
  if (host.empty() || !number || port < 0 || port > kHighestPort) return std::nullopt;
  return HttpAddress{.host = std::string(host), .port = port};
}

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

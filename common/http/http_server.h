#pragma once

// A small HTTP server: a few routes, and limits that no client can stretch.

#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/http_address.h"

namespace powderkeg {

struct HttpRequest {
  std::string body;                               // of a POST, unpacked
  std::map<std::string, std::string> parameters;  // of the query; the first of each name
  // When its last bytes were there, however long they waited for a thread.
  std::chrono::steady_clock::time_point arrival;
};

struct HttpReply {
  int status = 200;
  std::string body;
  std::string type = "application/json";
};

// {"error":"reason"}, on one line.
[[nodiscard]] HttpReply HttpError(int status, std::string_view reason);

struct HttpRoute {
  std::string method;  // GET or POST
  std::string path;    // of this route alone
  // Several threads call it at once. An exception is logged and answered with 500.
  std::function<HttpReply(const HttpRequest&)> answer;
};

struct HttpServerSettings {
  HttpAddress address{};
  bool any_port_if_taken = false;  // where it cannot listen on that port
  int threads = 64;                // requests served at once; more wait their turn
  // Connections whose request is on its way, at most a quarter of the process's descriptors;
  // beyond, those that have waited longest are closed.
  std::size_t max_waiting = 4096;
  std::size_t max_request_bytes = 64 << 10;  // of a body, packed and unpacked
  // For a whole request to arrive, and for its answer to leave.
  std::chrono::milliseconds io_timeout{2000};
};

// Serves from construction to destruction, HTTP/1.1, one request a connection. No thread waits for
// a request. What fits no route, is not understood, or comes from a page of another server in
// somebody's browser (by the headers Host, Origin, and Content-Type, which must be
// application/json) gets a 4xx status and an HttpError. Thread-safe.
class HttpServer {
 public:
  // Throws Error if it cannot listen.
  HttpServer(std::vector<HttpRoute> routes, const HttpServerSettings& settings);
  // Refuses new connections, answers those that wait.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  // Where it listens: with a port.
  [[nodiscard]] const HttpAddress& address() const;

 private:
  class Listener;
  std::unique_ptr<Listener> listener_;
};

}  // namespace powderkeg

#pragma once

// An agent service on a TCP port.

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>

#include "actors/http/agent_service.h"

namespace powderkeg {

struct HttpServerSettings {
  std::string host = "127.0.0.1";
  int port = 10080;                          // 0: any free one
  int threads = 64;                          // connections served at once; more wait their turn
  std::size_t max_waiting = 4096;            // then new ones wait in the kernel
  std::size_t max_request_bytes = 64 << 10;  // the runner sends less than 8 KiB
  // For a whole request to arrive, and for its answer to leave.
  std::chrono::milliseconds io_timeout{2000};
};

// Serves from construction to destruction: GET /ping, POST /init_agent, /action, /episode_end and
// /shutdown, HTTP/1.1, one request a connection. What is not understood gets a 4xx status and
// {"error":"one line"}. Thread-safe.
class HttpServer {
 public:
  // The service must outlive the server. Throws Error if it cannot listen.
  HttpServer(AgentService& service, const HttpServerSettings& settings);
  // Refuses new connections, answers those that wait.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  [[nodiscard]] int port() const;

 private:
  class Listener;
  std::unique_ptr<Listener> listener_;
};

}  // namespace powderkeg

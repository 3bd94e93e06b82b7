#include "common/http/http_client.h"

#include <functional>

#include "common/http/socket_stream.h"

namespace powderkeg {
namespace {

// The library's client, with limits of ours for each connection.
class Client final : public httplib::ClientImpl {
 public:
  Client(const HttpAddress& server, const HttpPatience& patience)
      : ClientImpl(server.host, server.port),
        limits_{.max_bytes = kMaxBytes, .timeout = patience.whole, .silence = patience.silence} {
    set_connection_timeout(patience.silence);
    set_decompress(false);  // a short answer would become one without end
    set_tcp_nodelay(true);
  }

  // What came of its only request.
  [[nodiscard]] HttpAnswer AnswerOf(const httplib::Result& result) const {
    using End = HttpAnswer::End;
    if (result) return {.end = End::kAnswered, .status = result->status, .body = result->body};
    const bool late = timed_out_ || result.error() == httplib::Error::ConnectionTimeout;
    return {.end = late ? End::kTimedOut : End::kFailed, .body = {}};
  }

 private:
  static constexpr std::size_t kMaxBytes = 64 << 10;

  bool process_socket(const Socket& socket,
                      std::function<bool(httplib::Stream& stream)> talk) override {
    SocketStream stream(socket.sock, limits_);
    const bool done = talk(stream);
    timed_out_ = stream.timed_out();
    return done;
  }

  const ConnectionLimits limits_;
  bool timed_out_ = false;
};

}  // namespace

HttpAnswer HttpGet(const HttpAddress& server, const std::string& path,
                   const HttpPatience& patience) {
  Client client(server, patience);
  return client.AnswerOf(client.Get(path));
}

HttpAnswer HttpPostJson(const HttpAddress& server, const std::string& path, const std::string& body,
                        const HttpPatience& patience) {
  Client client(server, patience);
  return client.AnswerOf(client.Post(path, body, "application/json"));
}

}  // namespace powderkeg

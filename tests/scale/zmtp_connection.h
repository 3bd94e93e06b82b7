#pragma once

// A DEALER's side of ZMTP 3.0 (ZeroMQ RFC 23, mechanism NULL) over one non-blocking TCP socket: ten
// thousand of these fit a process and one thread, which libzmq's sockets do not.

#include <netinet/in.h>

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace powderkeg {

// One thread. What fails ends the connection: open() tells.
class ZmtpConnection {
 public:
  explicit ZmtpConnection(const sockaddr_in& address);
  ~ZmtpConnection();
  ZmtpConnection(const ZmtpConnection&) = delete;
  ZmtpConnection& operator=(const ZmtpConnection&) = delete;

  [[nodiscard]] int socket() const { return socket_; }
  [[nodiscard]] bool open() const { return socket_ >= 0; }
  // Whether bytes wait for room in the socket.
  [[nodiscard]] bool wants_to_write() const { return !unsent_.empty(); }

  // Messages of one frame, in order.
  void Send(std::string_view message);
  // When the socket may have something: hands over whole messages.
  void Read(const std::function<void(std::string_view)>& take);
  void Write();

 private:
  void Close();
  // Of the bytes received, the first message; false: it is not whole yet.
  [[nodiscard]] bool Next(std::string_view& message, bool& is_command);

  int socket_;
  std::string unsent_;
  std::string early_;  // not to be sent before the peer is ready
  std::string received_;
  std::size_t taken_ = 0;  // of received_
  bool greeted_ = false;
  bool ready_ = false;
};

}  // namespace powderkeg

#pragma once

// A connection that cannot be held open, nor fed, without end.

#include <httplib.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>

namespace powderkeg {

// What one connection may take.
struct ConnectionLimits {
  std::size_t max_bytes;              // read from the peer
  std::chrono::milliseconds timeout;  // for all reads together, and for all writes from the first
  std::chrono::milliseconds silence = timeout;  // of the peer, before its next bytes
};

// The stream that httplib parses what a peer says from and writes what it is told to. Both fail
// after the limits, so that endless headers, endless bodies and one byte a second all end. The
// socket is whoever's made it. One thread.
class SocketStream final : public httplib::Stream {
 public:
  SocketStream(socket_t socket, const ConnectionLimits& limits);
  ~SocketStream() override = default;
  SocketStream(const SocketStream&) = delete;
  SocketStream& operator=(const SocketStream&) = delete;

  [[nodiscard]] bool is_readable() const override;
  [[nodiscard]] bool is_writable() const override;
  ssize_t read(char* data, std::size_t size) override;
  ssize_t write(const char* data, std::size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  [[nodiscard]] socket_t socket() const override { return socket_; }

  // Whether a read has failed because the peer said nothing, or not all, in time.
  [[nodiscard]] bool timed_out() const { return timed_out_; }

  // When the system received the last bytes so far, however long they waited for this thread; to
  // the system's tick (4 ms), rather too early.
  [[nodiscard]] std::chrono::steady_clock::time_point last_arrival() const;

 private:
  using Clock = std::chrono::steady_clock;

  // Waits for the event of poll(2); false after `deadline`.
  [[nodiscard]] bool Wait(short event, Clock::time_point deadline) const;
  // Refills the empty buffer, with nothing at the end of the stream; false on errors and beyond the
  // limits.
  [[nodiscard]] bool Fill();

  socket_t socket_;
  ConnectionLimits limits_;
  Clock::time_point read_deadline_;
  std::optional<Clock::time_point> write_deadline_;  // from the first write
  std::size_t bytes_left_;
  bool timed_out_ = false;
  std::array<char, 4096> buffer_;
  std::size_t begin_ = 0;  // of the unread bytes in the buffer
  std::size_t end_ = 0;
};

}  // namespace powderkeg

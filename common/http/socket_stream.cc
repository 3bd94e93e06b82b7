#include "common/http/socket_stream.h"

#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace powderkeg {

SocketStream::SocketStream(socket_t socket, const ConnectionLimits& limits)
    : socket_(socket),
      limits_(limits),
      read_deadline_(Clock::now() + limits.timeout),
      bytes_left_(limits.max_bytes) {}

bool SocketStream::is_readable() const { return begin_ < end_ || Wait(POLLIN, read_deadline_); }

bool SocketStream::is_writable() const {
  return Wait(POLLOUT, write_deadline_.value_or(Clock::now() + limits_.timeout));
}

ssize_t SocketStream::read(char* data, std::size_t size) {
  if (begin_ == end_ && !Fill()) return -1;
  const std::size_t count = std::min(size, end_ - begin_);
  std::memcpy(data, buffer_.data() + begin_, count);
  begin_ += count;
  return static_cast<ssize_t>(count);
}

ssize_t SocketStream::write(const char* data, std::size_t size) {
  if (!write_deadline_) write_deadline_ = Clock::now() + limits_.timeout;
  while (is_writable()) {
    const ssize_t sent = ::send(socket_, data, size, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent >= 0 || (errno != EINTR && errno != EAGAIN)) return sent;
  }
  return -1;
}

void SocketStream::get_remote_ip_and_port(std::string& ip, int& port) const {
  ip.clear();
  port = 0;
}

void SocketStream::get_local_ip_and_port(std::string& ip, int& port) const {
  ip.clear();
  port = 0;
}

SocketStream::Clock::time_point SocketStream::last_arrival() const {
  tcp_info info{};
  socklen_t size = sizeof(info);
  const bool known = ::getsockopt(socket_, IPPROTO_TCP, TCP_INFO, &info, &size) == 0;
  return Clock::now() - std::chrono::milliseconds(known ? info.tcpi_last_data_recv : 0);
}

bool SocketStream::Wait(short event, Clock::time_point deadline) const {
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
    pollfd question{.fd = socket_, .events = event, .revents = 0};
    const int ready = ::poll(&question, 1, static_cast<int>(std::max<long>(left, 0)));
    if (ready > 0) return true;
    if (ready == 0 || errno != EINTR) return false;
  }
}

bool SocketStream::Fill() {
  begin_ = end_ = 0;
  if (bytes_left_ == 0) return false;
  timed_out_ = !Wait(POLLIN, std::min(read_deadline_, Clock::now() + limits_.silence));
  if (timed_out_) return false;
  ssize_t received = 0;
  do {
    received = ::recv(socket_, buffer_.data(), std::min(buffer_.size(), bytes_left_), 0);
  } while (received < 0 && errno == EINTR);
  if (received < 0) return false;
  end_ = static_cast<std::size_t>(received);
  bytes_left_ -= end_;
  return true;
}

}  // namespace powderkeg

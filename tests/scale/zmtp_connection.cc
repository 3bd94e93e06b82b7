#include "tests/scale/zmtp_connection.h"

#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <utility>

#include "common/base/check.h"

namespace powderkeg {
namespace {

constexpr std::size_t kGreetingBytes = 64;
constexpr std::uint8_t kLong = 2;
constexpr std::uint8_t kCommand = 4;
constexpr std::size_t kLengthBytes = 8;

std::string Greeting() {
  std::string greeting(kGreetingBytes, '\0');
  greeting[0] = '\xff';
  greeting[9] = '\x7f';
  greeting[10] = 3;  // version 3.0
  greeting.replace(12, 4, "NULL");
  return greeting;
}

std::string Ready() {
  using namespace std::string_literals;
  const std::string body = "\x05READY\x0bSocket-Type\0\0\0\x06"s + "DEALER";
  return std::string{static_cast<char>(kCommand), static_cast<char>(body.size())} + body;
}

std::uint64_t LengthOf(std::string_view bytes) {
  std::uint64_t length = 0;
  for (std::size_t i = 0; i < kLengthBytes; ++i) {
    length = length << 8 | static_cast<std::uint8_t>(bytes[i]);
  }
  return length;
}

}  // namespace

ZmtpConnection::ZmtpConnection(const sockaddr_in& address)
    : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)),
      unsent_(Greeting() + Ready()) {
  if (socket_ < 0) throw Error("cannot open one more socket: see ulimit -n");
  const int on = 1;
  setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  const auto* any = reinterpret_cast<const sockaddr*>(&address);
  if (connect(socket_, any, sizeof address) != 0 && errno != EINPROGRESS) Close();
}

ZmtpConnection::~ZmtpConnection() { Close(); }

void ZmtpConnection::Close() {
  if (socket_ >= 0) close(socket_);
  socket_ = -1;
}

void ZmtpConnection::Send(std::string_view message) {
  const std::uint64_t size = message.size();
  std::string& bytes = ready_ ? unsent_ : early_;
  bytes += static_cast<char>(kLong);
  for (int shift = 56; shift >= 0; shift -= 8) bytes += static_cast<char>(size >> shift & 0xff);
  bytes += message;
}

void ZmtpConnection::Write() {
  while (open() && !unsent_.empty()) {
    const ssize_t sent = send(socket_, unsent_.data(), unsent_.size(), MSG_NOSIGNAL);
    if (sent > 0) {
      unsent_.erase(0, static_cast<std::size_t>(sent));
    } else if (errno == EAGAIN || errno == ENOTCONN) {
      return;
    } else {
      Close();
    }
  }
}

void ZmtpConnection::Read(const std::function<void(std::string_view)>& take) {
  static std::array<char, 1 << 18> buffer;
  while (open()) {
    const ssize_t count = recv(socket_, buffer.data(), buffer.size(), 0);
    if (count <= 0) {
      if (count == 0 || errno != EAGAIN) Close();
      break;
    }
    received_.append(buffer.data(), static_cast<std::size_t>(count));
    if (static_cast<std::size_t>(count) < buffer.size()) break;
  }
  if (!greeted_ && received_.size() >= kGreetingBytes) {
    taken_ = kGreetingBytes;
    greeted_ = true;
  }
  std::string_view message;
  bool is_command = false;
  while (open() && greeted_ && Next(message, is_command)) {
    if (!is_command) {
      take(message);
    } else if (!std::exchange(ready_, true)) {
      unsent_ += std::exchange(early_, {});
    }
  }
  received_.erase(0, taken_);
  taken_ = 0;
  if (received_.empty()) std::string().swap(received_);
}

bool ZmtpConnection::Next(std::string_view& message, bool& is_command) {
  const std::string_view rest = std::string_view(received_).substr(taken_);
  if (rest.size() < 2) return false;
  const auto flags = static_cast<std::uint8_t>(rest[0]);
  const bool is_long = (flags & kLong) != 0;
  const std::size_t head = 1 + (is_long ? kLengthBytes : 1);
  if (rest.size() < head) return false;
  const std::uint64_t size =
      is_long ? LengthOf(rest.substr(1)) : static_cast<std::uint8_t>(rest[1]);
  if (rest.size() - head < size) return false;
  message = rest.substr(head, size);
  is_command = (flags & kCommand) != 0;
  taken_ += head + size;
  return true;
}

}  // namespace powderkeg

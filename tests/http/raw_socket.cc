#include "tests/http/raw_socket.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>

#include "common/base/check.h"

namespace powderkeg {

int ConnectTo(int port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  CHECK(socket >= 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  CHECK(::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0);
  return socket;
}

void SendAll(int socket, const std::string& bytes) {
  std::size_t sent = 0;
  while (sent < bytes.size()) {
    const ssize_t count = ::send(socket, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (count <= 0) return;
    sent += static_cast<std::size_t>(count);
  }
}

std::string ReadToEnd(int socket) {
  std::string all;
  std::array<char, 4096> part{};
  ssize_t count = 0;
  while ((count = ::recv(socket, part.data(), part.size(), 0)) > 0) {
    all.append(part.data(), static_cast<std::size_t>(count));
  }
  ::close(socket);
  return all;
}

std::string ExchangeBytes(int port, const std::string& bytes) {
  const int socket = ConnectTo(port);
  SendAll(socket, bytes);
  ::shutdown(socket, SHUT_WR);
  return ReadToEnd(socket);
}

}  // namespace powderkeg

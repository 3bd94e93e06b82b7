#include "common/wire/connection_watch.h"

#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <tuple>
#include <utility>
#include <vector>

namespace powderkeg {
namespace {

// That have come to a socket and that its owner has not read; nullopt if the socket is gone.
std::optional<std::uint64_t> BytesWaiting(int socket) {
  int waiting = 0;
  if (ioctl(socket, FIONREAD, &waiting) != 0) return std::nullopt;
  return static_cast<std::uint64_t>(std::max(waiting, 0));
}

// That have come in all; nullopt where the system does not count them.
std::optional<std::uint64_t> BytesReceived(int socket) {
  tcp_info info{};
  socklen_t size = sizeof info;
  constexpr std::size_t kEnd =
      offsetof(tcp_info, tcpi_bytes_received) + sizeof info.tcpi_bytes_received;
  if (getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) != 0 || size < kEnd) return {};
  return info.tcpi_bytes_received;
}

// A look at a connection takes about two microseconds.
constexpr std::chrono::microseconds kWhileGrowing{50};
constexpr std::chrono::microseconds kElse{400};
constexpr std::uint64_t kGrowth = 16 << 20;

// Of the process in memory; 0 if the system does not say.
std::uint64_t ResidentBytes() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages >> pages;
  return pages * 4096;
}

}  // namespace

void ConnectionWatch::Opened(int socket) {
  connections_.insert_or_assign(socket, Connection{.number = opened_++, .turn = turn_});
}

void ConnectionWatch::Heard(int socket) {
  const auto found = connections_.find(socket);
  if (found == connections_.end()) return;
  found->second.heard = true;
  found->second.stranger = false;
  // Those who have a message are heard one after the other.
  if (++heard_ < 2 * connections_.size()) return;
  heard_ = 0;
  ++turn_;
}

// Nobody sends without an end and lets nothing wait: where the system does not count, what waits
// counts, unless it is what waited before.
std::optional<std::uint64_t> ConnectionWatch::BytesRead(int socket, Connection& connection) {
  const auto waiting = BytesWaiting(socket);
  if (!waiting) return std::nullopt;
  if (const auto received = BytesReceived(socket)) return *received - *waiting;
  if (*waiting != std::exchange(connection.waiting, *waiting)) connection.guessed += *waiting;
  return connection.guessed;
}

void ConnectionWatch::Look(std::uint64_t bytes, Connection& connection) const {
  if (connection.heard) {
    connection.heard = false;
    connection.base = bytes;
  } else if (turn_ == connection.turn) {
    return;
  }
  connection.unfinished = std::max(connection.seen, connection.base) - connection.base;
  connection.seen = bytes;
  connection.turn = turn_;
}

void ConnectionWatch::Cut(int socket) {
  shutdown(socket, SHUT_RDWR);
  connections_.erase(socket);
}

std::size_t ConnectionWatch::CutExcess() {
  return (IsTimeToLook() ? CutUnfinished() : 0) + CutSurplus();
}

// What does not end takes memory.
bool ConnectionWatch::IsTimeToLook() {
  const Clock::time_point now = Clock::now();
  if (now < last_look_ + kWhileGrowing * connections_.size()) return false;
  const std::uint64_t resident = ResidentBytes();
  const bool grows = resident == 0 || resident > resident_ + kGrowth;
  if (!grows && now < last_look_ + kElse * connections_.size()) return false;
  last_look_ = now;
  resident_ = resident;
  return true;
}

std::size_t ConnectionWatch::CutUnfinished() {
  std::size_t cut = 0;
  std::uint64_t unfinished = 0;
  for (auto next = connections_.begin(); next != connections_.end();) {
    auto& [socket, connection] = *next++;
    const auto bytes = BytesRead(socket, connection);
    if (bytes) Look(*bytes, connection);
    if (bytes && connection.unfinished <= limits_.unfinished) {
      unfinished += connection.unfinished;
      continue;
    }
    if (bytes) ++cut;
    Cut(socket);
  }
  if (connections_.empty()) return cut;
  if (unfinished > limits_.unfinished_in_all) {
    Cut(std::ranges::max_element(connections_, {}, [](const auto& entry) {
          return entry.second.unfinished;
        })->first);
    ++cut;
  }
  return cut;
}

// The oldest stranger goes first: whoever has just come needs a moment to say something.
std::size_t ConnectionWatch::CutSurplus() {
  if (connections_.size() <= limits_.connections) return 0;
  const std::size_t surplus = connections_.size() - limits_.connections;
  std::vector<std::tuple<bool, std::uint64_t, int>> sockets;
  for (const auto& [socket, connection] : connections_) {
    sockets.emplace_back(!connection.stranger, connection.number, socket);
  }
  std::ranges::nth_element(sockets, sockets.begin() + static_cast<std::ptrdiff_t>(surplus));
  for (std::size_t i = 0; i < surplus; ++i) Cut(std::get<int>(sockets[i]));
  return surplus;
}

}  // namespace powderkeg

#pragma once

// Keeps the connections of a server within bounds that ZeroMQ does not know: how many there are,
// and how much it holds of messages that have not ended.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

namespace powderkeg {

struct ConnectionLimits {
  std::size_t connections;
  // Bytes of a message that has not ended, as the system has counted them or, where it does not
  // (ipc), as looks at what waits tell: of one connection, and of all together.
  std::uint64_t unfinished;
  std::uint64_t unfinished_in_all;
};

// Cuts connections by shutting their sockets down; the owner then closes them. Beyond the bound it
// cuts those first that have said nothing yet, the oldest of them first; of unfinished messages the
// longest. What has come from a connection belongs to a message that has not ended if nothing was
// heard from it although everybody who had a message has been heard since. One thread.
class ConnectionWatch {
 public:
  explicit ConnectionWatch(const ConnectionLimits& limits) : limits_(limits) {}

  void Opened(int socket);
  void Closed(int socket) { connections_.erase(socket); }
  // A message came from it.
  void Heard(int socket);
  // Nobody has a message waiting.
  void AllHeard() { ++turn_; }

  // To be called some fifty times a second. How many were cut. Unfinished messages are looked for
  // each time where there are few connections, and less often where there are many, so that it
  // takes little of a processor: a twentieth at most while the process grows, else half a
  // hundredth.
  std::size_t CutExcess();

  [[nodiscard]] std::size_t size() const { return connections_.size(); }

 private:
  using Clock = std::chrono::steady_clock;

  struct Connection {
    std::uint64_t number;  // in the order of opening
    bool stranger = true;
    bool heard = false;      // since the last look
    std::uint64_t base = 0;  // bytes that had come when it was heard last
    std::uint64_t seen = 0;  // that had come in turn `turn`
    std::uint64_t turn = 0;
    std::uint64_t unfinished = 0;
    std::uint64_t waiting = 0;  // at the last look, and
    std::uint64_t guessed = 0;  // that have come, where the system does not count
  };

  // What the socket's owner has read from it; nullopt if the socket is gone.
  [[nodiscard]] static std::optional<std::uint64_t> BytesRead(int socket, Connection& connection);
  void Look(std::uint64_t bytes, Connection& connection) const;
  void Cut(int socket);
  [[nodiscard]] bool IsTimeToLook();
  std::size_t CutUnfinished();
  std::size_t CutSurplus();

  const ConnectionLimits limits_;
  std::map<int, Connection> connections_;  // by socket
  std::uint64_t opened_ = 0;
  std::uint64_t turn_ = 0;   // in each everybody who had a message is heard
  std::uint64_t heard_ = 0;  // messages in this turn
  Clock::time_point last_look_;
  std::uint64_t resident_ = 0;  // bytes of the process at the last look
};

}  // namespace powderkeg

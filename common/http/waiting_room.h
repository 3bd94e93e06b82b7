#pragma once

// Connections that nobody needs a thread for: whose request is on its way, or whose answer is.

#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <stop_token>

#include "common/base/worker.h"

namespace powderkeg {

struct WaitingRoomSettings {
  std::size_t max_connections;        // more: the one that has waited longest is closed
  std::size_t max_bytes;              // of a request; more are not waited for
  std::chrono::milliseconds timeout;  // after it (and up to a quarter more) a connection is closed
};

// Owns the sockets in it. Thread-safe.
class WaitingRoom {
 public:
  // Takes over a socket. Called on the room's thread.
  using Ready = std::function<void(int socket)>;

  // Throws Error where the system has no descriptors left.
  WaitingRoom(const WaitingRoomSettings& settings, Ready ready);
  ~WaitingRoom();
  WaitingRoom(const WaitingRoom&) = delete;
  WaitingRoom& operator=(const WaitingRoom&) = delete;

  // A connection whose request may be on its way: handed on when it is there, as far as can be
  // known, or when the peer sends no more. Nothing is read from it.
  void Admit(int socket);
  // A connection that was answered: the peer gets the time to read that before it is closed. What
  // it still sends is dropped.
  void Dismiss(int socket);

  // Hands on whose request is there and nobody from then on. What is left is closed with the room.
  void Close();

 private:
  using Clock = std::chrono::steady_clock;
  struct Visitor {
    Clock::time_point deadline;
    bool answered;
    std::size_t bytes_left;  // that are dropped
  };

  void Enter(int socket, const Visitor& visitor);
  void Run(const std::stop_token& stop);
  // Takes care of what has happened on a socket.
  void Attend(int socket, bool ended);
  // Whether the peer of an answered connection has gone, or sends without end.
  [[nodiscard]] static bool HasLeft(int socket, Visitor& visitor);
  [[nodiscard]] bool IsRequestThere(int socket) const;
  void CloseLate(Clock::time_point now);

  const WaitingRoomSettings settings_;
  const Ready ready_;
  int poll_ = -1;                    // epoll(7), told once of each change
  int stop_ = -1;                    // eventfd(2)
  std::mutex mutex_;                 // guards what follows
  std::map<int, Visitor> visitors_;  // by socket
  std::optional<Worker> worker_;
};

}  // namespace powderkeg

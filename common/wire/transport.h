#pragma once

// The seam between session and sockets: whole messages between one server and many clients, in
// order and at most once per connection.

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/wire/waker.h"

namespace powderkeg {

// An actor's end of one connection. One thread; `Waker` is for the others.
class ClientChannel {
 public:
  virtual ~ClientChannel() = default;

  // Does not wait. False: not connected yet, or the queue to the peer is full; nothing was sent.
  virtual bool Send(const std::string& bytes) = 0;
  // The next message; nullopt if none came within `timeout` or `waker` was notified, which clears
  // it.
  virtual std::optional<std::string> Receive(std::chrono::milliseconds timeout,
                                             const Waker& waker) = 0;
  // What is known of why there is no connection: for the operator.
  [[nodiscard]] virtual std::string Trouble() { return "no answer"; }
};

// Makes a fresh connection; does not wait until it stands. Throws Error if the address is no use.
using Connect = std::function<std::unique_ptr<ClientChannel>()>;

// A connection as the server names it; never chosen by the peer, not reused while known.
using PeerId = std::string;

struct Incoming {
  PeerId peer{};
  std::string bytes{};
  std::string key_owner{};  // whose key the peer has; empty: there are no keys
};

// The learner's end of all connections. One thread; `Waker` is for the others. Closing it drops
// what clients have received and not yet read: whoever needs a message read waits for an answer to
// it.
class ServerChannel {
 public:
  virtual ~ServerChannel() = default;

  // Does not wait. False: the peer is gone or does not read; nothing was sent.
  virtual bool Send(const PeerId& peer, const std::string& bytes) = 0;
  // The same, of bytes that go to many: they are kept, not copied.
  virtual bool SendShared(const PeerId& peer, const std::shared_ptr<const std::string>& bytes) = 0;
  // As ClientChannel::Receive, but may give up sooner.
  virtual std::optional<Incoming> Receive(std::chrono::milliseconds timeout,
                                          const Waker& waker) = 0;
  // Where clients on this machine connect to, a chosen port included.
  [[nodiscard]] virtual std::string endpoint() const = 0;
};

}  // namespace powderkeg

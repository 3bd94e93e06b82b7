#pragma once

// Channels within one process, for tests: no sockets, and messages can be lost or
// changed on purpose.

#include <functional>
#include <memory>
#include <string>

#include "common/wire/transport.h"

namespace powderkeg {

// Connects any number of clients with the server that listens at the time; a new Listen replaces
// the old server. Thread-safe. Channels may outlive the network.
class InProcessNetwork {
 public:
  // Decides whether a message passes, and may change it; called under a lock, so it must not use
  // the network.
  using Filter = std::function<bool(std::string& bytes)>;

  InProcessNetwork();

  [[nodiscard]] std::unique_ptr<ServerChannel> Listen();
  [[nodiscard]] std::unique_ptr<ClientChannel> Connect();

  void FilterToServer(Filter filter);
  void FilterToClients(Filter filter);

  struct Shared;

 private:
  std::shared_ptr<Shared> shared_;
};

}  // namespace powderkeg

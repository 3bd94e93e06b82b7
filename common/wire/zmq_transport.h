#pragma once

// Channels over ZeroMQ: tcp://HOST:PORT or ipc://PATH; encrypted and authenticated by CURVE where
// keys are given.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "common/wire/keys.h"
#include "common/wire/transport.h"

namespace powderkeg {

// Whether only this machine can reach the address: ipc, or tcp on the loopback interface.
[[nodiscard]] bool IsLocal(const std::string& endpoint);

struct ListenSettings {
  std::string endpoint;  // tcp://*:PORT, tcp://127.0.0.1:0 (any free port), ipc://PATH
  // Folder of keys (keys.h); without one nothing is encrypted and everybody is let in.
  std::optional<std::filesystem::path> keys{};
  // Without keys only local addresses are listened on, unless this says otherwise.
  bool allow_insecure = false;
};

// A ROUTER that is bound. Throws Error if the address is in use or not allowed, or a key is
// missing.
[[nodiscard]] std::unique_ptr<ServerChannel> ListenZmq(const ListenSettings& settings);

// A DEALER that connects, again and again until it is destroyed; it may hold what is not yet sent
// for up to a second then. Throws Error if the address is malformed.
[[nodiscard]] std::unique_ptr<ClientChannel> ConnectZmq(const std::string& endpoint,
                                                        const std::optional<ClientKeys>& keys);

}  // namespace powderkeg

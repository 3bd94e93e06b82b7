#pragma once

// Requests to a server that is not trusted.

#include <chrono>
#include <cstdint>
#include <string>

#include "common/base/http_address.h"

namespace powderkeg {

struct HttpPatience {
  std::chrono::milliseconds silence;  // to connect, and before the next bytes of the answer
  std::chrono::milliseconds whole;    // for all of the answer
};

struct HttpAnswer {
  enum class End : std::uint8_t {
    kAnswered,
    kTimedOut,
    kFailed,  // no connection, no HTTP, or cut off
  };
  End end = End::kFailed;
  int status = 0;    // of kAnswered
  std::string body;  // of kAnswered
};

// One request over a connection of its own, and its answer of at most 64 KiB. Waits as long as the
// patience lasts (a name may take the system longer to look up). Thread-safe.
[[nodiscard]] HttpAnswer HttpGet(const HttpAddress& server, const std::string& path,
                                 const HttpPatience& patience);
[[nodiscard]] HttpAnswer HttpPostJson(const HttpAddress& server, const std::string& path,
                                      const std::string& body, const HttpPatience& patience);

}  // namespace powderkeg

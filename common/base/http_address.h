#pragma once

// Where an HTTP server listens.

#include <optional>
#include <string>
#include <string_view>

namespace powderkeg {

struct HttpAddress {
  std::string host = "127.0.0.1";  // "::1", without brackets
  int port = 0;                    // 0: any free one

  // "127.0.0.1:8265", "[::1]:8265"
  [[nodiscard]] std::string text() const;
  // "http://127.0.0.1:8265/"
  [[nodiscard]] std::string url() const;

  friend bool operator==(const HttpAddress&, const HttpAddress&) = default;
};

// "127.0.0.1:8265", "localhost:8265" or "[::1]:8265"; nullopt for anything else.
[[nodiscard]] std::optional<HttpAddress> ParseHttpAddress(std::string_view text);

// "::1" of "[::1]"; any other host as it is.
[[nodiscard]] std::string_view WithoutBrackets(std::string_view host);

}  // namespace powderkeg

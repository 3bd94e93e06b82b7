#include "common/base/http_address.h"

#include "common/base/check.h"
#include "common/base/number.h"

namespace powderkeg {

std::string HttpAddress::text() const {
  const bool ipv6 = host.find(':') != std::string::npos;
  return StrCat(ipv6 ? "[" + host + "]" : host, ":", port);
}

std::string HttpAddress::url() const { return StrCat("http://", text(), "/"); }

std::optional<HttpAddress> ParseHttpAddress(std::string_view text) {
  constexpr int kHighestPort = 65535;
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return std::nullopt;
  const std::string_view host = WithoutBrackets(text.substr(0, colon));
  const auto port = ParseNumber<int>(text.substr(colon + 1));
  if (host.empty() || !port || *port < 0 || *port > kHighestPort) return std::nullopt;
  return HttpAddress{.host = std::string(host), .port = *port};
}

std::string_view WithoutBrackets(std::string_view host) {
  const bool brackets = host.starts_with('[') && host.ends_with(']');
  return brackets ? host.substr(1, host.size() - 2) : host;
}

}  // namespace powderkeg

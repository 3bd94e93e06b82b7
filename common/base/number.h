#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace powderkeg {

// The number that the whole text is: decimal, '.' in fractions whatever the locale, no spaces, no
// '+'. nullopt where it is none or out of the type's range.
template <typename Number>
[[nodiscard]] std::optional<Number> ParseNumber(std::string_view text) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || rest != end) return std::nullopt;
  return number;
}

}  // namespace powderkeg

#pragma once

#include <string>

namespace powderkeg {

// printf into a string.
[[gnu::format(printf, 1, 2)]] [[nodiscard]] std::string Format(const char* format, ...);

}  // namespace powderkeg

#pragma once

// The canary of weights that stand in a file of another format.

#include <cstdint>
#include <span>
#include <vector>

#include "common/model/weights_snapshot.h"

namespace powderkeg {

// The bytes of a canary in a .weights file (weights_format.cc).
[[nodiscard]] std::vector<std::uint8_t> SerializeCanary(const Canary& canary);
// Throws Error that says what is wrong. Safe on untrusted bytes.
[[nodiscard]] Canary DeserializeCanary(std::span<const std::uint8_t> bytes);

}  // namespace powderkeg

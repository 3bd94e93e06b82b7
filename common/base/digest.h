#pragma once

// Checksums: SHA-256 where bytes must be the very same, CRC-32C where storage or a wire may damage
// them.

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace powderkeg {

using Sha256Digest = std::array<std::uint8_t, 32>;

// FIPS 180-4.
[[nodiscard]] Sha256Digest Sha256(std::span<const std::uint8_t> bytes);

// CRC-32C (Castagnoli polynomial, as in iSCSI, RFC 3720 B.4).
[[nodiscard]] std::uint32_t Crc32c(std::span<const std::uint8_t> bytes);

// A string's characters as bytes, without a copy.
[[nodiscard]] inline std::span<const std::uint8_t> BytesOf(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace powderkeg

#pragma once

// The arithmetic of a network evaluation.

#include <cstdint>
#include <string_view>

namespace powderkeg {

enum class Precision : std::uint8_t {
  kFp32,
  kBf16,  // 8 bits of mantissa: policies within about 0.02 of fp32
  kFp16,  // CUDA only
  kInt8,  // oneDNN only: steps chosen for each network (common/onednn/quantization.h)
};

// "fp32", "bf16", "fp16", "int8".
[[nodiscard]] std::string_view NameOf(Precision precision);
// The inverse; throws Error on another name.
[[nodiscard]] Precision PrecisionByName(std::string_view name);

}  // namespace powderkeg

#pragma once

// A fuzzer's input as the choices of a test.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace powderkeg {

// Gives 0 and nothing where the input has ended. A value.
class ByteSource {
 public:
  ByteSource(const std::uint8_t* data, std::size_t size)
      : left_(reinterpret_cast<const char*>(data), size) {}

  [[nodiscard]] bool empty() const { return left_.empty(); }
  [[nodiscard]] std::uint8_t Next() {
    const std::string_view byte = Take(1);
    return byte.empty() ? std::uint8_t{0} : static_cast<std::uint8_t>(byte[0]);
  }
  // From 0 to below `end`, which is at most 65,536.
  [[nodiscard]] std::size_t Below(std::size_t end) {
    const std::size_t high = Next();
    return end == 0 ? 0 : (high << 8 | Next()) % end;
  }
  [[nodiscard]] std::string_view Take(std::size_t size) {
    const std::string_view taken = left_.substr(0, size);
    left_.remove_prefix(taken.size());
    return taken;
  }
  [[nodiscard]] std::string_view Rest() { return Take(left_.size()); }

 private:
  std::string_view left_;
};

// Other values for some bytes: three of the source for each, where and what.
template <typename Bytes>
void Damage(ByteSource& source, Bytes& bytes) {
  while (!source.empty() && !bytes.empty()) {
    auto& byte = bytes[source.Below(std::min<std::size_t>(bytes.size(), 65'536))];
    byte = static_cast<typename Bytes::value_type>(source.Next());
  }
}

}  // namespace powderkeg

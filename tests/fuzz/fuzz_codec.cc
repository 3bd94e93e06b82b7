// Everything that is decoded from a peer. First byte: what the rest is.

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <variant>

#include "common/wire/codec.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace powderkeg;
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] % 2 == 0) {
    const Decoded<GameRecord> record = DecodeRecord(bytes);
    if (const auto* value = std::get_if<GameRecord>(&record)) (void)Verify(*value);
  } else {
    const Decoded<WireMessage> message = Decode(bytes);
    if (const auto* value = std::get_if<WireMessage>(&message)) (void)Encode(*value);
  }
  return 0;
}

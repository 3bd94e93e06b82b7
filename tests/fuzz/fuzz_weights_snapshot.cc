// Whatever bytes arrive as weights, the answer is an Error or a valid snapshot that can be written
// and read again.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/base/check.h"
#include "common/model/weights_snapshot.h"

powderkeg::WeightsSnapshot Reread(const powderkeg::WeightsSnapshot& snapshot) {
  return powderkeg::Deserialize(powderkeg::Serialize(snapshot));
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, size);
  try {
    const powderkeg::WeightsSnapshot snapshot = powderkeg::Deserialize(bytes);
    CHECK(
        std::ranges::equal(powderkeg::Serialize(snapshot), powderkeg::Serialize(Reread(snapshot))));
  } catch (const powderkeg::Error&) {
  }
  return 0;
}

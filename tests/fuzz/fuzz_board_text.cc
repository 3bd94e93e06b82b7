// Any bytes as board text: a position that survives printing, or an Error.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "common/base/check.h"
#include "tests/pommerman/board_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const powderkeg::State state =
        powderkeg::FromText(std::string_view(reinterpret_cast<const char*>(data), size));
    CHECK(powderkeg::FromText(powderkeg::ToText(state)) == state);
  } catch (const powderkeg::Error&) {
  }
  return 0;
}

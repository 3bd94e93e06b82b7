// Settings files: what is read comes back from its own text.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "common/base/check.h"
#include "common/config/config.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace powderkeg;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const RunConfig config = ParseConfig(text, "fuzz", {});
    CHECK(ParseConfig(ToText(config), "again", {}) == config);
  } catch (const Error&) {  // the text is of no use
  }
  return 0;
}

// Any bytes as lines of recorded games: read and replayed, or refused with an Error.

#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>

#include "common/base/check.h"
#include "tools/official/recorded_replay.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream text(std::string(reinterpret_cast<const char*>(data), size));
  powderkeg::RecordedGameReader reader(
      "fuzz", [&](std::string& line) { return static_cast<bool>(std::getline(text, line)); });
  try {
    for (powderkeg::RecordedGame game; reader.Next(game);) {
      if (game.Known()) (void)powderkeg::ReplayDifferences(game);
    }
  } catch (const powderkeg::Error&) {
  }
  return 0;
}

#include "common/config/foreign_settings.h"

#include <vector>

namespace powderkeg {

OptionTable<ForeignSettings> ForeignOptions() {
  using Settings = ForeignSettings;
  static const std::vector<Option<Settings>> table = {
      OptionOf<&Settings::move_ms>("move_ms", Between(1, 3'600'000),
                                   "how long it may be silent before a move is late and stop is "
                                   "played; the official code has 150, its rules 100"),
      OptionOf<&Settings::start_s>("start_s", Between(0, 3600),
                                   "how long it may take to answer its first /ping"),
  };
  return table;
}

}  // namespace powderkeg

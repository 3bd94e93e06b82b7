#pragma once

// A server of the official agent protocol, and how long its runner waits.

#include "common/base/http_address.h"
#include "common/config/options.h"

namespace powderkeg {

// Which options there are, their meaning and range: ForeignOptions.
struct ForeignSettings {
  HttpAddress server{};
  int move_ms = 150;
  int start_s = 30;

  friend bool operator==(const ForeignSettings&, const ForeignSettings&) = default;
};

[[nodiscard]] OptionTable<ForeignSettings> ForeignOptions();

}  // namespace powderkeg

#pragma once

// How the pessimist plays.

#include "common/config/options.h"

namespace powderkeg {

// Which options there are, their meaning and range: PessimistOptions.
struct PessimistSettings {
  int depth = 2;
  int near = 6;
  int spread = 3;
  double fear = 0.5;
  int own = 4000;
  int mate = 3000;
  int enemy = 2000;
  int siege = 60;
  int kill = 500;

  friend bool operator==(const PessimistSettings&, const PessimistSettings&) = default;
};

[[nodiscard]] OptionTable<PessimistSettings> PessimistOptions();

}  // namespace powderkeg

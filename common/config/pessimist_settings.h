#pragma once

// How the pessimist plays.

#include "common/config/options.h"

namespace powderkeg {

// Which options there are, their meaning and range: PessimistOptions.
struct PessimistSettings {
  int depth = 2;
  int near = 6;
  int spread = 3;
  int hold = 12;
  int own_spread = 1;
  double fear = 0.5;
  double own_weight = 4000;
  double enemy_weight = 2000;
  double mate_weight = 3000;
  double kill = 500;
  double siege = 20;
  double bomb = 4;

  double wood = 12;
  double chase = 1;

  friend bool operator==(const PessimistSettings&, const PessimistSettings&) = default;
};

[[nodiscard]] OptionTable<PessimistSettings> PessimistOptions();

}  // namespace powderkeg

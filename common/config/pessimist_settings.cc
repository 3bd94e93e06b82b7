#include "common/config/pessimist_settings.h"

#include <vector>

namespace powderkeg {

OptionTable<PessimistSettings> PessimistOptions() {
  using Settings = PessimistSettings;
  constexpr Allowed kWeight = Between(0, 20'000);
  static const std::vector<Option<Settings>> table = {
      OptionOf<&Settings::depth>("depth", Between(1, 4),
                                 "own moves that are tried; one more where no enemy is near"),
      OptionOf<&Settings::near>("near", Between(0, 20),
                                "the first moves of enemies within that distance are tried, of two "
                                "at most"),
      OptionOf<&Settings::spread>("spread", Between(0, 12),
                                  "steps for which enemies go everywhere at once"),
      OptionOf<&Settings::fear>("fear", Between(0, 1),
                                "share of the worst reply in an action's value; the rest is the "
                                "mean"),
      OptionOf<&Settings::own>("own", kWeight, "what it is worth to have room to live"),
      OptionOf<&Settings::mate>("mate", kWeight, "that the mate has room"),
      OptionOf<&Settings::enemy>("enemy", kWeight, "that an enemy has hardly any room"),
      OptionOf<&Settings::siege>("siege", kWeight, "that an enemy has half the room"),
      OptionOf<&Settings::kill>("kill", kWeight, "that an enemy has none"),
  };
  return table;
}

}  // namespace powderkeg

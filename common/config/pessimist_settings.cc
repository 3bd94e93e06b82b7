#include "common/config/pessimist_settings.h"

#include <vector>

namespace powderkeg {

OptionTable<PessimistSettings> PessimistOptions() {
  using Settings = PessimistSettings;
  static const std::vector<Option<Settings>> table = {
      OptionOf<&Settings::depth>("depth", Between(1, 4), "own moves that are tried one by one"),
      OptionOf<&Settings::near>("near", Between(0, 20), "enemies in that distance: moves tried"),
      OptionOf<&Settings::spread>("spread", Between(0, 12), ""),
      OptionOf<&Settings::hold>("hold", Between(0, 12), ""),
      OptionOf<&Settings::own_spread>("own_spread", Between(0, 12), ""),
      OptionOf<&Settings::fear>("fear", Between(0, 1), ""),
      OptionOf<&Settings::own_weight>("own", Between(0, 1e6), ""),
      OptionOf<&Settings::enemy_weight>("enemy", Between(0, 1e6), ""),
      OptionOf<&Settings::mate_weight>("mate", Between(0, 1e6), ""),
      OptionOf<&Settings::kill>("kill", Between(0, 1e6), ""),
      OptionOf<&Settings::siege>("siege", Between(0, 1e6), ""),
      OptionOf<&Settings::bomb>("bomb", Between(-1e6, 1e6), ""),
      OptionOf<&Settings::wood>("wood", Between(0, 1e6), ""),
      OptionOf<&Settings::chase>("chase", Between(0, 1e6), ""),
  };
  return table;
}

}  // namespace powderkeg

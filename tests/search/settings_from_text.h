#pragma once

#include <string_view>

#include "common/config/agent_spec.h"

namespace powderkeg {

// "simulations=7,tree=two_player" as the options of an agent; none gives the defaults.
inline SearchSettings ParseSearchSettings(std::string_view options) {
  return ParseAgent(StrCat("search:", options)).search;
}

}  // namespace powderkeg

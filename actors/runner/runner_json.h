#pragma once

// Request bodies as the official runner writes them.

#include <nlohmann/json.hpp>
#include <string>

#include "common/pommerman/observation.h"

namespace powderkeg {

// The observation as the object that the runner encodes: keys in its order, whole numbers of the
// bomb and flame arrays as floats ("9.0").
[[nodiscard]] nlohmann::ordered_json ObservationObject(const GameSettings& settings,
                                                       const Observation& observation);

// {"obs": "<text of the object>", "action_space": "6" or "[6, 8, 8]"}
[[nodiscard]] std::string ActionBody(const nlohmann::ordered_json& observation);
[[nodiscard]] std::string ActionBody(const GameSettings& settings, const Observation& observation);

// {"id": "2", "game_type": "1"}
[[nodiscard]] std::string InitBody(AgentId id, Mode mode);

}  // namespace powderkeg

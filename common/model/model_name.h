#pragma once

// Models by the names that users give them.

#include <string>

#include "common/model/weights_snapshot.h"

namespace powderkeg {

// Wherever a model is named:
//   what holds a '/' or '.' and exists   that weights file
//   untrained:NETWORK[:SEED]             fresh weights (NetworkByName), the same for equal seeds
//   latest, latest:RUN                   the newest weights of the run that last wrote some, of RUN
//   any other word                       models/WORD.weights
// models/ and runs/ stand in the folder that the environment variable POWDERKEG_HOME names, or else
// in the nearest above the program that has a models/: the repository's.
inline constexpr const char* kModelHelp =
    "a weights file (with a '/' or '.' in its name), a name in models/ such as ffa, latest, "
    "latest:RUN, or untrained:NETWORK[:SEED]";

// A name of the same model that stays: a file's, or untrained:NETWORK:SEED. Throws Error that says
// which models there are.
[[nodiscard]] std::string ResolvedModel(const std::string& name);

// The model of that name. Throws Error.
[[nodiscard]] Snapshot LoadModel(const std::string& name);

}  // namespace powderkeg

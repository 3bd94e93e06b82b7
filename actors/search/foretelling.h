#pragma once

// What an evaluation foretells of the agents other than its viewer.

#include <cstdint>
#include <span>

#include "common/base/rng.h"
#include "common/model/evaluator.h"
#include "common/pommerman/step.h"

namespace powderkeg {

using Foretelling = decltype(Evaluation::others);
// Probabilities of one agent's six actions in 255ths; all 0 where nothing is foretold.
using ForetoldActions = std::span<const std::uint8_t, kActionCount>;

// Requires agent != viewer.
[[nodiscard]] ForetoldActions ForetoldOf(const Foretelling& foretelling, AgentId viewer,
                                         AgentId agent);

// The sum over the actions of `among`; 0: nothing is foretold of them.
[[nodiscard]] int SumOf(ForetoldActions foretold, ActionSet among);

// An action of `legal` by its probability; the lowest, without a draw, if nothing is foretold.
[[nodiscard]] Action DrawnAction(ForetoldActions foretold, ActionSet legal, Rng& rng);

}  // namespace powderkeg

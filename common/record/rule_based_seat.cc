#include "common/record/rule_based_seat.h"

#include "common/pommerman/observation.h"

namespace powderkeg {

Action RuleBasedSeat::Decide(const GameSettings& settings, const State& state) {
  const BitBoard visible = VisibleCells(settings, state.agents[self_].cell);
  const PolicyView view{state, settings, self_, visible};
  return powderkeg::Decide(kind_, view, traits_, memory_, rng_);
}

}  // namespace powderkeg

#pragma once

// How a simulated game ends for the searching agent, and what that is worth.

#include "actors/search/tree.h"
#include "common/config/search_settings.h"
#include "common/model/outcome_value.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/step.h"

namespace powderkeg {

// A value; `game` is as it really is, whatever the search knows of its step limit.
class Ends {
 public:
  Ends(const SearchSettings& settings, const GameSettings& game);

  // Whether it is over for `self` in the position of `node`, which the game reached with this
  // outcome: then the node is terminal, proven where somebody won or nothing is left to win, and
  // has its evaluation, unless the mate's view decides (Node::Stage::kAsksMate).
  void Judge(const Outcome& outcome, AgentId self, Node& node) const;

 private:
  [[nodiscard]] float ValueOfEnd(int outcome, const Node& node) const;

  OutcomeValues values_;
  int max_steps_;
  Mode mode_;
  bool mate_value_on_death_;
};

}  // namespace powderkeg

#include "actors/search/ends.h"

#include <algorithm>

namespace powderkeg {
namespace {

constexpr float kOwnDeathInTeam = -0.5F;

}  // namespace

Ends::Ends(const SearchSettings& settings, const GameSettings& game)
    : values_{.draw = settings.draw_value, .late_win = settings.late_win_value},
      max_steps_(game.max_steps),
      mode_(game.mode),
      mate_value_on_death_(settings.mate_value_on_death) {}

void Ends::Judge(const Outcome& outcome, AgentId self, Node& node) const {
  if (!outcome.done && node.state.agents[self].alive) return;
  node.stage = Node::Stage::kTerminal;
  if (outcome.done && outcome.result == Result::kTie) {
    node.evaluation = ValueOfEnd(0, node);
  } else if (outcome.done) {
    node.proven = outcome.Won(self) ? 1 : -1;
    node.evaluation = ValueOfEnd(node.proven, node);
  } else if (!IsTeamMode(mode_)) {
    node.proven = -1;
    node.evaluation = node.proven;
  } else if (mate_value_on_death_ && node.state.agents[TeamMateOf(mode_, self)].alive) {
    node.stage = Node::Stage::kAsksMate;
  } else {
    node.evaluation = kOwnDeathInTeam;
  }
}

float Ends::ValueOfEnd(int outcome, const Node& node) const {
  return ValueOf(values_, outcome, std::min<int>(node.state.step, max_steps_), max_steps_);
}

}  // namespace powderkeg

#include "tools/official/recorded_replay.h"

#include <string_view>
#include <vector>

#include "common/base/check.h"
#include "common/pommerman/board_text.h"

namespace powderkeg {
namespace {

// Collects differences under the heading of a place in a game.
class Comparison {
 public:
  Comparison(const RecordedGame& game, std::vector<std::string>& differences)
      : game_(game), differences_(differences) {}

  void set_step(int step) { step_ = step; }

  template <typename Value>
  void Expect(std::string_view what, const Value& recorded, const Value& played) {
    if (recorded == played) return;
    Report(StrCat(what, ": recorded ", recorded, ", played ", played));
  }

  void ExpectState(const State& recorded, const State& played) {
    if (recorded == played) return;
    Report(StrCat("state: recorded\n", ToText(recorded), "played\n", ToText(played)));
  }

  void ExpectObservations(const std::optional<RecordedObservations>& recorded,
                          const State& played) {
    if (!recorded) return;
    AgentId id = 0;
    for (const RecordedObservation& seen : *recorded) {
      ExpectObservation(id, seen, OfficialObservation(game_.settings, played, id));
      ++id;
    }
  }

 private:
  void Report(const std::string& text) {
    differences_.push_back(StrCat(game_.id, " (", game_.tag, ") step ", step_, ": ", text));
  }

  void ExpectObservation(AgentId id, const RecordedObservation& recorded,
                         const RecordedObservation& played);

  const RecordedGame& game_;
  std::vector<std::string>& differences_;
  int step_ = 0;
};

// The cells in which two arrays of an observation differ, with both values.
template <typename Cells>
std::string CellDifferences(const char* name, const Cells& recorded, const Cells& played) {
  std::string text;
  for (Cell cell = 0; cell < kCellCount; ++cell) {
    if (recorded[cell] == played[cell]) continue;
    text += StrCat(' ', name, '(', RowOf(cell), ',', ColumnOf(cell), ") recorded ",
                   static_cast<int>(recorded[cell]), " played ", static_cast<int>(played[cell]));
  }
  return text;
}

std::string OwnFields(const RecordedObservation& recorded) {
  const Observation& seen = recorded.observation;
  std::string text = StrCat("position ", int{seen.position}, " strength ", int{seen.blast_strength},
                            " kick ", seen.can_kick, " ammo ", int{seen.ammo}, " step ", seen.step,
                            " message ", int{seen.message[0]}, ' ', int{seen.message[1]}, " alive");
  for (const bool alive : seen.alive) text += StrCat(' ', alive);
  text += StrCat(" teammate ", static_cast<int>(recorded.team_mate), " enemies");
  for (const CellValue enemy : recorded.enemies) text += StrCat(' ', static_cast<int>(enemy));
  return text + StrCat(" type ", recorded.game_type, ' ', recorded.environment);
}

void Comparison::ExpectObservation(AgentId id, const RecordedObservation& recorded,
                                   const RecordedObservation& played) {
  if (recorded == played) return;
  const Observation& a = recorded.observation;
  const Observation& b = played.observation;
  std::string text = StrCat("observation of agent ", id, ':');
  text += CellDifferences("board", a.board, b.board);
  text += CellDifferences("strength", a.bomb_blast_strength, b.bomb_blast_strength);
  text += CellDifferences("life", a.bomb_life, b.bomb_life);
  text += CellDifferences("direction", a.bomb_moving_direction, b.bomb_moving_direction);
  text += CellDifferences("flame", a.flame_life, b.flame_life);
  const std::string recorded_fields = OwnFields(recorded);
  const std::string played_fields = OwnFields(played);
  if (recorded_fields != played_fields) {
    text += StrCat(" recorded ", recorded_fields, " played ", played_fields);
  }
  Report(text);
}

std::string RewardText(const std::array<std::int8_t, kAgentCount>& rewards) {
  std::string text;
  for (const std::int8_t reward : rewards) text += StrCat(int{reward}, ' ');
  return text;
}

// Result and winners. A recorder that cuts a game off leaves it incomplete.
void ExpectEnd(const RecordedGame& game, const Outcome& outcome, Comparison& comparison) {
  comparison.Expect("result", static_cast<int>(game.result), static_cast<int>(outcome.result));
  comparison.Expect("winners", int{game.winners}, int{outcome.winners});
}

}  // namespace

RecordedObservation OfficialObservation(const GameSettings& settings, const State& state,
                                        AgentId self) {
  const OfficialFields fields = OfficialFieldsOf(settings, self);
  return {.observation = Observe(settings, state, self),
          .team_mate = fields.team_mate,
          .enemies = fields.enemies,
          .game_type = static_cast<int>(settings.mode),
          .environment = fields.environment};
}

std::vector<std::string> ReplayDifferences(const RecordedGame& game) {
  CHECK(game.Known(), game.mode);
  std::vector<std::string> differences;
  Comparison comparison(game, differences);
  comparison.ExpectObservations(game.observations, game.start);
  State state = game.start;
  Outcome outcome;
  for (const RecordedStep& step : game.steps) {
    comparison.set_step(state.step);
    Step(game.settings, step.actions, step.messages, state);
    outcome = OutcomeOf(game.settings, state);
    comparison.Expect("rewards", RewardText(step.rewards), RewardText(outcome.rewards));
    comparison.Expect("done", step.done, outcome.done);
    comparison.ExpectObservations(step.observations, state);
    Collapse(game.settings, state);
    comparison.ExpectState(step.state, state);
    state = step.state;
  }
  if (!game.steps.empty()) ExpectEnd(game, outcome, comparison);
  return differences;
}

}  // namespace powderkeg

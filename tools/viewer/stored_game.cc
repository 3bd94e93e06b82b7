#include "tools/viewer/stored_game.h"

#include <optional>
#include <string_view>

#include "common/base/check.h"
#include "common/pommerman/generate.h"
#include "common/pommerman/step.h"
#include "tools/official/recorded_replay.h"

namespace powderkeg {
namespace {

constexpr int kStepsBetweenObservations = 5;

std::string_view ModeName(Mode mode) {
  switch (mode) {
    case Mode::kFreeForAll: return "ffa";
    case Mode::kTeam: return "team";
    case Mode::kTeamRadio: return "radio";
    case Mode::kOneVsOne: return "one_vs_one";
  }
  return "";
}

// The first official id with these settings, or "unknown".
std::string EnvironmentIdOf(const GameSettings& settings) {
  constexpr std::string_view kSeparator = ", ";
  std::string ids = KnownEnvironmentIds();
  while (!ids.empty()) {
    const std::string id = ids.substr(0, ids.find(kSeparator));
    if (GameSettingsFor(id) == settings) return id;
    ids.erase(0, id.size() + kSeparator.size());
  }
  return "unknown";
}

std::optional<RecordedObservations> ObserveForRecord(const GameSettings& settings,
                                                     const State& state) {
  const bool everybody_knows = settings.mode == Mode::kFreeForAll;
  if (everybody_knows || state.step % kStepsBetweenObservations != 0) return {};
  RecordedObservations observations;
  for (AgentId id = 0; id < SeatCount(settings.mode); ++id) {
    observations.push_back(OfficialObservation(settings, state, id));
  }
  return observations;
}

RecordedStep PlayStep(const GameSettings& settings, const JointAction& actions, State& state) {
  RecordedStep step;
  step.actions = actions;
  Step(settings, actions, state);
  const Outcome outcome = OutcomeOf(settings, state);
  step.rewards = outcome.rewards;
  step.done = outcome.done;
  step.observations = ObserveForRecord(settings, state);
  Collapse(settings, state);
  step.state = state;
  return step;
}

RecordedGame StartOf(const GameRecord& record) {
  RecordedGame game;
  game.id = StrCat("ticket-", record.ticket);
  game.settings = record.setup.settings;
  game.environment = EnvironmentIdOf(game.settings);
  game.mode = ModeName(game.settings.mode);
  game.tag = record.evaluator;
  game.start = GenerateStart(game.settings, record.setup.start, BoardRng(record.setup));
  game.observations = ObserveForRecord(game.settings, game.start);
  return game;
}

}  // namespace

StoredGame StoredGameFrom(const GameRecord& record) {
  if (const auto reason = Verify(record)) {
    throw Error(StrCat("the game of ticket ", record.ticket, " is not valid: ", *reason));
  }
  StoredGame stored{.game = StartOf(record), .players = {}, .tracks = record.tracks};
  State state = stored.game.start;
  for (const JointAction& actions : record.actions) {
    stored.game.steps.push_back(PlayStep(stored.game.settings, actions, state));
  }
  stored.game.result = record.outcome.result;
  stored.game.winners = record.outcome.winners;
  for (AgentId id = 0; id < kAgentCount; ++id) {
    const Seat& seat = record.setup.seats[id];
    stored.players[id] = seat.searches ? "search" : NameOf(seat.policy);
  }
  return stored;
}

const State& PositionAfter(const RecordedGame& game, int step) {
  CHECK(step >= 0 && step <= static_cast<int>(game.steps.size()), step);
  return step == 0 ? game.start : game.steps[step - 1].state;
}

}  // namespace powderkeg

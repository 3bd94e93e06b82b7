#include "learner/report/status_json.h"

#include <nlohmann/json.hpp>
#include <string_view>

#include "common/base/check.h"

namespace powderkeg {
namespace {

using Json = nlohmann::ordered_json;

std::string_view StateName(Phase phase) {
  switch (phase) {
    case Phase::kPlaying: return "playing";
    case Phase::kWaitingForActors:
    case Phase::kWaitingForGame: return "waiting";
    case Phase::kPreparing: return "preparing";
    case Phase::kTraining: return "training";
    case Phase::kComplete: return "complete";
  }
  return "";
}

void AddPhase(const LiveStatus& status, Json& json) {
  const Phase phase = PhaseOf(status);
  json["state"] = StateName(phase);
  if (phase == Phase::kWaitingForActors) json["waiting_for"] = "actors";
  if (phase == Phase::kWaitingForGame) json["waiting_for"] = StrCat("game ", *status.straggler);
}

Json IntakeJson(const IntakeStatistics& intake) {
  return {{"games", intake.games},
          {"decisions", intake.decisions},
          {"games_pending", intake.pending_games},
          {"duplicates", intake.duplicates},
          {"rejected", intake.rejected},
          {"other_settings", intake.other_settings},
          {"malformed", intake.malformed},
          {"sessions_lost", intake.sessions_lost},
          {"tickets_issued", intake.tickets_issued}};
}

Json ActorJson(const ActorStatistics& actor) {
  const Heartbeat& heartbeat = actor.heartbeat;
  return {{"name", actor.name},
          {"games", actor.games},
          {"rejected", actor.rejected},
          {"tickets", actor.tickets},
          {"silence_ms", actor.silence.count()},
          {"games_played", heartbeat.games},
          {"decisions", heartbeat.decisions},
          {"simulations", heartbeat.simulations},
          {"evaluations", heartbeat.evaluations},
          {"batches", heartbeat.batches},
          {"games_running", heartbeat.games_running},
          {"spool_games", heartbeat.outbox_games},
          {"spool_bytes", heartbeat.outbox_bytes},
          {"oldest_game_ms", heartbeat.oldest_game.count()},
          {"weights_version", heartbeat.weights_version}};
}

}  // namespace

std::string StatusJson(const RunView& view) {
  const LiveStatus& status = view.status;
  Json json = {{"run", view.run}, {"started_unix_s", view.started_unix_s}};
  AddPhase(status, json);
  json["iterations_done"] = status.iterations_done;
  json["iterations"] = status.iterations;
  json["decisions"] = status.decisions;
  json["decisions_wanted"] = status.decisions_wanted;
  json["decisions_beyond"] = status.decisions_beyond;
  json["samples"] = status.samples;
  json["samples_wanted"] = status.samples_wanted;
  json["intake"] = IntakeJson(view.intake);
  json["actors"] = Json::array();
  for (const ActorStatistics& actor : view.intake.actors) {
    json["actors"].push_back(ActorJson(actor));
  }
  return json.dump(/*indent=*/-1, ' ', /*ensure_ascii=*/false, Json::error_handler_t::replace);
}

}  // namespace powderkeg

#include "learner/report/status_json.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <vector>

#include "common/base/check.h"
#include "learner/report/figures.h"

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

// Whole numbers without a point; null for what is no number.
Json NumberJson(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == std::trunc(value)) return static_cast<std::int64_t>(value);
  return value;
}

template <typename Source>
void AddFigures(std::span<const LiveFigure<Source>> figures, const Source& source, Json& json) {
  for (const auto& figure : figures) json[figure.name] = NumberJson(figure.value(source));
}

Json IterationJson(const std::vector<double>& values) {
  Json json;
  for (std::size_t i = 0; i < values.size(); ++i) {
    json[IterationFigures()[i].name] = NumberJson(values[i]);
  }
  return json;
}

}  // namespace

std::string StatusJson(const RunView& view) {
  Json json = {{"run", view.run}, {"started_unix_s", view.started_unix_s}};
  AddPhase(view.status, json);
  AddFigures(RunFigures(), view.status, json);
  AddFigures(IntakeFigures(), view.intake, json["intake"]);
  json["actors"] = Json::array();
  for (const ActorStatistics& actor : view.intake.actors) {
    AddFigures(ActorFigures(), actor, json["actors"].emplace_back(Json{{"name", actor.name}}));
  }
  if (view.last_iteration) json["last_iteration"] = IterationJson(*view.last_iteration);
  return json.dump(/*indent=*/-1, ' ', /*ensure_ascii=*/false, Json::error_handler_t::replace);
}

}  // namespace powderkeg

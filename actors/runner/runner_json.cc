#include "actors/runner/runner_json.h"

#include <array>

namespace powderkeg {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr int kAgent0 = static_cast<int>(CellValue::kAgent0);

template <typename Number, typename Value>
OrderedJson Rows(const std::array<Value, kCellCount>& cells, int size) {
  OrderedJson rows = OrderedJson::array();
  for (int row = 0; row < size; ++row) {
    OrderedJson values = OrderedJson::array();
    for (int column = 0; column < size; ++column) {
      values.push_back(static_cast<Number>(cells[CellAt(row, column)]));
    }
    rows.push_back(values);
  }
  return rows;
}

OrderedJson Alive(const Observation& observation) {
  OrderedJson alive = OrderedJson::array();
  for (int id = 0; id < kAgentCount; ++id) {
    if (observation.alive[id]) alive.push_back(kAgent0 + id);
  }
  return alive;
}

}  // namespace

OrderedJson ObservationObject(const GameSettings& settings, const Observation& observation) {
  const int size = settings.board_size;
  const OfficialFields fields = OfficialFieldsOf(settings, observation.self);
  OrderedJson object;
  object["alive"] = Alive(observation);
  object["board"] = Rows<int>(observation.board, size);
  object["bomb_blast_strength"] = Rows<double>(observation.bomb_blast_strength, size);
  object["bomb_life"] = Rows<double>(observation.bomb_life, size);
  object["bomb_moving_direction"] = Rows<double>(observation.bomb_moving_direction, size);
  object["flame_life"] = Rows<double>(observation.flame_life, size);
  object["game_type"] = static_cast<int>(settings.mode);
  object["game_env"] = fields.environment;
  object["position"] = {RowOf(observation.position), ColumnOf(observation.position)};
  object["blast_strength"] = observation.blast_strength;
  object["can_kick"] = observation.can_kick;
  object["teammate"] = fields.team_mate;
  object["ammo"] = observation.ammo;
  object["enemies"] = fields.enemies;
  object["step_count"] = observation.step;
  if (settings.mode == Mode::kTeamRadio) object["message"] = observation.message;
  return object;
}

std::string ActionBody(const OrderedJson& observation) {
  const bool radio = observation.is_object() && observation.contains("message");
  OrderedJson body;
  body["obs"] = observation.dump();
  body["action_space"] = radio ? "[6, 8, 8]" : "6";
  return body.dump();
}

std::string ActionBody(const GameSettings& settings, const Observation& observation) {
  return ActionBody(ObservationObject(settings, observation));
}

std::string InitBody(AgentId id, Mode mode) {
  OrderedJson body;
  body["id"] = std::to_string(id);
  body["game_type"] = std::to_string(static_cast<int>(mode));
  return body.dump();
}

}  // namespace powderkeg

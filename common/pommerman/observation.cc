#include "common/pommerman/observation.h"

#include <cstdlib>

#include "common/base/check.h"

namespace powderkeg {
namespace {

void Paint(BitBoard cells, CellValue value, Observation& observation) {
  ForEachCell(cells, [&](Cell cell) { observation.board[cell] = value; });
}

void ShowBoard(const State& state, BitBoard visible, Observation& observation) {
  const BitBoard items = state.VisibleItems() & visible;
  Paint(~visible, CellValue::kFog, observation);
  Paint(state.rigid & visible, CellValue::kRigid, observation);
  Paint(state.wood & visible, CellValue::kWood, observation);
  Paint(items & state.item_low & ~state.item_high, CellValue::kExtraBomb, observation);
  Paint(items & state.item_high & ~state.item_low, CellValue::kIncreaseRange, observation);
  Paint(items & state.item_high & state.item_low, CellValue::kKick, observation);
  Paint(state.bomb_cells & visible, CellValue::kBomb, observation);
  Paint(state.Flames() & visible, CellValue::kFlames, observation);
  for (AgentId id = 0; id < kAgentCount; ++id) {
    const AgentState& agent = state.agents[id];
    if (agent.alive && visible.Has(agent.cell)) {
      observation.board[agent.cell] = AgentValue(id);
    }
  }
}

void ShowBombs(const State& state, BitBoard visible, Observation& observation) {
  for (const Bomb& bomb : state.Bombs()) {
    if (!visible.Has(bomb.cell)) continue;
    observation.bomb_blast_strength[bomb.cell] = bomb.blast_strength;
    observation.bomb_life[bomb.cell] = static_cast<std::uint8_t>(bomb.life);
    observation.bomb_moving_direction[bomb.cell] = bomb.direction();
  }
}

// Where several flames burn, the newest counts.
void ShowFlames(const State& state, BitBoard visible, Observation& observation) {
  for (int life = 0; life < static_cast<int>(state.flames.size()); ++life) {
    ForEachCell(state.flames[life] & visible, [&](Cell cell) {
      observation.flame_life[cell] = static_cast<std::uint8_t>(life + 1);
    });
  }
}

void ShowOneself(const GameSettings& settings, const State& state, Observation& observation) {
  const AgentState& self = state.agents[observation.self];
  observation.position = self.cell;
  observation.blast_strength = self.blast_strength;
  observation.can_kick = self.can_kick;
  observation.ammo = self.ammo;
  if (settings.mode == Mode::kTeamRadio) {
    observation.message = state.messages[TeamMateOf(settings.mode, observation.self)];
  }
}

}  // namespace

Observation Observe(const GameSettings& settings, const State& state, AgentId self) {
  const BitBoard visible = VisibleCells(settings, state.agents[self].cell);
  Observation observation{};
  observation.self = self;
  observation.step = state.step;
  for (AgentId id = 0; id < kAgentCount; ++id) observation.alive[id] = state.agents[id].alive;
  ShowBoard(state, visible, observation);
  ShowBombs(state, visible, observation);
  ShowFlames(state, visible, observation);
  ShowOneself(settings, state, observation);
  return observation;
}

OfficialFields OfficialFieldsOf(const GameSettings& settings, AgentId self) {
  OfficialFields fields;
  const Mode mode = settings.mode;
  const AgentId team_mate = TeamMateOf(mode, self);
  if (team_mate >= 0) fields.team_mate = AgentValue(team_mate);
  for (AgentId other = 0; other < SeatCount(mode); ++other) {
    if (AreEnemies(mode, self, other)) fields.enemies.push_back(AgentValue(other));
  }
  if (IsTeamMode(mode)) fields.enemies.push_back(CellValue::kAgentDummy);
  const bool collapses = settings.collapse_steps != GameSettings{}.collapse_steps;
  const int version = mode == Mode::kTeamRadio ? 2 : collapses ? 1 : 0;
  fields.environment = StrCat("pommerman.envs.v", version, ":Pomme");
  return fields;
}

BitBoard VisibleCells(const GameSettings& settings, Cell position) {
  const int radius = settings.view_radius;
  if (radius == 0) return BitBoard::All();
  BitBoard rows;
  BitBoard columns;
  for (int i = 0; i < kBoardSize; ++i) {
    if (std::abs(i - RowOf(position)) <= radius) rows |= BitBoard::Row(i);
    if (std::abs(i - ColumnOf(position)) <= radius) columns |= BitBoard::Column(i);
  }
  return rows & columns;
}

}  // namespace powderkeg

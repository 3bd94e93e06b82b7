#include "common/pommerman/state.h"

#include <algorithm>

namespace powderkeg {

void State::SetItem(Cell cell, Item item) {
  RemoveItems(BitBoard::Of(cell));
  if ((static_cast<int>(item) & 1) != 0) item_low.Add(cell);
  if ((static_cast<int>(item) & 2) != 0) item_high.Add(cell);
}

void State::AddBomb(const Bomb& bomb) {
  CHECK(bomb_count < kMaxBombs && !bomb_cells.Has(bomb.cell));
  bombs[bomb_count++] = bomb;
  bomb_cells.Add(bomb.cell);
}

void State::RemoveBombs(BitBoard cells) {
  const auto all = Bombs();
  const auto end = std::remove_if(all.begin(), all.end(),
                                  [cells](const Bomb& bomb) { return cells.Has(bomb.cell); });
  std::fill(end, all.end(), Bomb{});
  bomb_count = static_cast<std::uint8_t>(end - all.begin());
  bomb_cells &= ~cells;
}

const Bomb* State::BombAt(Cell cell) const {
  if (!bomb_cells.Has(cell)) return nullptr;
  const auto all = Bombs();
  const auto found = std::ranges::find(all, cell, &Bomb::cell);
  return found == all.end() ? nullptr : &*found;
}

BitBoard State::AgentCells() const {
  BitBoard cells;
  for (const AgentState& agent : agents) {
    if (agent.alive) cells.Add(agent.cell);
  }
  return cells;
}

BitBoard State::Walkable() const { return ~(rigid | wood | bomb_cells | Flames() | AgentCells()); }

CellValue State::ValueAt(Cell cell) const {
  for (int id = 0; id < kAgentCount; ++id) {
    if (agents[id].alive && agents[id].cell == cell) return AgentValue(id);
  }
  if (Flames().Has(cell)) return CellValue::kFlames;
  if (bomb_cells.Has(cell)) return CellValue::kBomb;
  if (rigid.Has(cell)) return CellValue::kRigid;
  if (wood.Has(cell)) return CellValue::kWood;
  switch (ItemAt(cell)) {
    case Item::kExtraBomb: return CellValue::kExtraBomb;
    case Item::kIncreaseRange: return CellValue::kIncreaseRange;
    case Item::kKick: return CellValue::kKick;
    case Item::kNone: break;
  }
  return CellValue::kPassage;
}

}  // namespace powderkeg

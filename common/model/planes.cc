#include "common/model/planes.h"

#include <algorithm>
#include <array>

namespace powderkeg {
namespace {

// Where each group of planes.h starts.
enum Plane : int {
  kRigid = 0,
  kWood = 1,
  kItems = 2,
  kBombTime = 5,
  kBombReach = 6,
  kMotionHorizontal = 7,
  kMotionVertical = 8,
  kFlames = 9,
  kAgents = kOwnCellPlane,
  kOwnReach = 14,
  kOwnBombs = 15,
  kOwnCapacity = 16,
  kOwnKick = 17,
  kAlive = 18,
  kStep = 22,
};

constexpr float kFreshBombLife = 9.0F;
constexpr float kFullReach = 11.0F;
constexpr float kManyBombs = 5.0F;
constexpr float kFlameSteps = 3.0F;

float Ratio(int count, float whole) { return std::min(1.0F, static_cast<float>(count) / whole); }

// Writes into planes that are all 0 at first; only visible cells are touched.
class PlaneWriter {
 public:
  PlaneWriter(std::span<float, kPlanesSize> planes, BitBoard visible)
      : planes_(planes), visible_(visible), full_view_(visible == BitBoard::All()) {
    std::ranges::fill(planes_, 0.0F);
  }

  void Set(int plane, BitBoard cells, float value) {
    float* const cell_values = &At(plane, 0);
    ForEachCell(cells & visible_, [&](Cell cell) { cell_values[cell] = value; });
  }
  void Set(int plane, Cell cell, float value) {
    if (visible_.Has(cell)) At(plane, cell) = value;
  }
  void Fill(int plane, float value) {
    if (value == 0.0F) return;
    if (full_view_) {
      std::fill_n(&At(plane, 0), kCellCount, value);
    } else {
      Set(plane, visible_, value);
    }
  }

 private:
  float& At(int plane, Cell cell) {
    return planes_[static_cast<std::size_t>(plane * kCellCount + cell)];
  }

  std::span<float, kPlanesSize> planes_;
  BitBoard visible_;
  bool full_view_;
};

void WriteBoard(const State& state, PlaneWriter& writer) {
  writer.Set(kRigid, state.rigid, 1.0F);
  writer.Set(kWood, state.wood, 1.0F);
  const BitBoard items = state.VisibleItems();
  if (items.Any()) {
    writer.Set(kItems + 0, items & state.item_low & ~state.item_high, 1.0F);
    writer.Set(kItems + 1, items & state.item_high & ~state.item_low, 1.0F);
    writer.Set(kItems + 2, items & state.item_high & state.item_low, 1.0F);
  }
  for (std::size_t life = 0; life < state.flames.size(); ++life) {
    writer.Set(kFlames, state.flames[life], static_cast<float>(life + 1) / kFlameSteps);
  }
}

void WriteMotion(const Bomb& bomb, PlaneWriter& writer) {
  switch (bomb.direction()) {
    case Direction::kLeft: writer.Set(kMotionHorizontal, Cell{bomb.cell}, -1.0F); break;
    case Direction::kRight: writer.Set(kMotionHorizontal, Cell{bomb.cell}, 1.0F); break;
    case Direction::kUp: writer.Set(kMotionVertical, Cell{bomb.cell}, 1.0F); break;
    case Direction::kDown: writer.Set(kMotionVertical, Cell{bomb.cell}, -1.0F); break;
    case Direction::kNone: break;
  }
}

void WriteBombs(const State& state, PlaneWriter& writer) {
  for (const Bomb& bomb : state.Bombs()) {
    writer.Set(kBombTime, Cell{bomb.cell}, 1.0F - static_cast<float>(bomb.life) / kFreshBombLife);
    writer.Set(kBombReach, Cell{bomb.cell}, Ratio(bomb.blast_strength - 1, kFullReach));
    WriteMotion(bomb, writer);
  }
}

void WriteAgents(const State& state, AgentId viewer, PlaneWriter& writer) {
  for (int seat = 0; seat < kAgentCount; ++seat) {
    const AgentState& agent = state.agents[static_cast<std::size_t>((viewer + seat) % kAgentCount)];
    if (!agent.alive) continue;
    writer.Set(kAgents + seat, Cell{agent.cell}, 1.0F);
    writer.Fill(kAlive + seat, 1.0F);
  }
}

void WriteOwnStatistics(const State& state, AgentId viewer, PlaneWriter& writer) {
  const AgentState& self = state.agents[static_cast<std::size_t>(viewer)];
  const auto own_bombs = static_cast<int>(std::ranges::count(state.Bombs(), viewer, &Bomb::owner));
  writer.Fill(kOwnReach, Ratio(self.blast_strength - 1, kFullReach));
  writer.Fill(kOwnBombs, Ratio(own_bombs, kManyBombs));
  writer.Fill(kOwnCapacity, Ratio(self.ammo + own_bombs, kManyBombs));
  writer.Fill(kOwnKick, self.can_kick ? 1.0F : 0.0F);
}

}  // namespace

Cell OwnCell(const Position& position) {
  const AgentState& self = position.state->agents[static_cast<std::size_t>(position.viewer)];
  return self.alive && position.visible.Has(self.cell) ? Cell{self.cell} : kNoCell;
}

void EncodePlanes(const GameSettings& settings, const Position& position,
                  std::span<float, kPlanesSize> planes) {
  const State& state = *position.state;
  PlaneWriter writer(planes, position.visible);
  WriteBoard(state, writer);
  WriteBombs(state, writer);
  WriteAgents(state, position.viewer, writer);
  WriteOwnStatistics(state, position.viewer, writer);
  writer.Fill(kStep, Ratio(state.step, static_cast<float>(std::max(1, settings.max_steps - 1))));
}

}  // namespace powderkeg

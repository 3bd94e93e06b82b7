#include "common/model/planes.h"

#include <algorithm>
#include <array>
#include <type_traits>

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

constexpr int kFullReach = 11;
constexpr int kManyBombs = 5;
constexpr int kFlameSteps = 3;

// What a plane's counts are divided by; that of the step depends on the game.
constexpr std::array<int, kPlaneCount> kWholes = [] {
  std::array<int, kPlaneCount> wholes{};
  wholes.fill(1);
  wholes[kBombTime] = kFreshBombLife;
  wholes[kBombReach] = wholes[kOwnReach] = kFullReach;
  wholes[kFlames] = kFlameSteps;
  wholes[kOwnBombs] = wholes[kOwnCapacity] = kManyBombs;
  return wholes;
}();

// Writes counts into planes that are all 0 at first, as ratios where the planes are floats; only
// visible cells are touched.
template <typename Value, std::size_t size>
class PlaneWriter {
 public:
  PlaneWriter(std::span<Value, size> planes, BitBoard visible)
      : planes_(planes), visible_(visible), full_view_(visible == BitBoard::All()) {
    std::ranges::fill(planes_, Value{0});
  }

  void Set(int plane, BitBoard cells, int count) {
    Value* const cell_values = &At(plane, 0);
    const Value value = ValueOf(plane, count);
    ForEachCell(cells & visible_, [&](Cell cell) { cell_values[cell] = value; });
  }
  void Set(int plane, Cell cell, int count) {
    if (visible_.Has(cell)) At(plane, cell) = ValueOf(plane, count);
  }
  void Fill(int plane, int count) { FillWith(plane, ValueOf(plane, count)); }
  void FillWith(int plane, Value value) {
    if (value == Value{0}) return;
    if (full_view_) {
      std::fill_n(&At(plane, 0), kCellCount, value);
    } else {
      Value* const cell_values = &At(plane, 0);
      ForEachCell(visible_, [&](Cell cell) { cell_values[cell] = value; });
    }
  }

 private:
  static Value ValueOf(int plane, int count) {
    if constexpr (std::is_floating_point_v<Value>) {
      const int whole = kWholes[static_cast<std::size_t>(plane)];
      return static_cast<Value>(count) / static_cast<Value>(whole);
    } else {
      return static_cast<Value>(count);
    }
  }
  Value& At(int plane, Cell cell) {
    return planes_[static_cast<std::size_t>(plane * kCellCount + cell)];
  }

  std::span<Value, size> planes_;
  BitBoard visible_;
  bool full_view_;
};

template <typename Writer>
void WriteBoard(const State& state, Writer& writer) {
  writer.Set(kRigid, state.rigid, 1);
  writer.Set(kWood, state.wood, 1);
  const BitBoard items = state.VisibleItems();
  if (items.Any()) {
    writer.Set(kItems + 0, items & state.item_low & ~state.item_high, 1);
    writer.Set(kItems + 1, items & state.item_high & ~state.item_low, 1);
    writer.Set(kItems + 2, items & state.item_high & state.item_low, 1);
  }
  for (std::size_t life = 0; life < state.flames.size(); ++life) {
    writer.Set(kFlames, state.flames[life], static_cast<int>(life) + 1);
  }
}

template <typename Writer>
void WriteMotion(const Bomb& bomb, Writer& writer) {
  switch (bomb.direction()) {
    case Direction::kLeft: writer.Set(kMotionHorizontal, Cell{bomb.cell}, -1); break;
    case Direction::kRight: writer.Set(kMotionHorizontal, Cell{bomb.cell}, 1); break;
    case Direction::kUp: writer.Set(kMotionVertical, Cell{bomb.cell}, 1); break;
    case Direction::kDown: writer.Set(kMotionVertical, Cell{bomb.cell}, -1); break;
    case Direction::kNone: break;
  }
}

template <typename Writer>
void WriteBombs(const State& state, Writer& writer) {
  for (const Bomb& bomb : state.Bombs()) {
    writer.Set(kBombTime, Cell{bomb.cell}, kFreshBombLife - bomb.life);
    writer.Set(kBombReach, Cell{bomb.cell}, std::min(bomb.blast_strength - 1, kFullReach));
    WriteMotion(bomb, writer);
  }
}

template <typename Writer>
void WriteAgents(const State& state, AgentId viewer, Writer& writer) {
  for (int seat = 0; seat < kAgentCount; ++seat) {
    const AgentState& agent = state.agents[static_cast<std::size_t>((viewer + seat) % kAgentCount)];
    if (!agent.alive) continue;
    writer.Set(kAgents + seat, Cell{agent.cell}, 1);
    writer.Fill(kAlive + seat, 1);
  }
}

template <typename Writer>
void WriteOwnStatistics(const State& state, AgentId viewer, Writer& writer) {
  const AgentState& self = state.agents[static_cast<std::size_t>(viewer)];
  const auto own_bombs = static_cast<int>(std::ranges::count(state.Bombs(), viewer, &Bomb::owner));
  writer.Fill(kOwnReach, std::min(self.blast_strength - 1, kFullReach));
  writer.Fill(kOwnBombs, std::min(own_bombs, kManyBombs));
  writer.Fill(kOwnCapacity, std::min(self.ammo + own_bombs, kManyBombs));
  writer.Fill(kOwnKick, self.can_kick ? 1 : 0);
}

template <typename Writer>
void WriteAllButStep(const Position& position, Writer& writer) {
  WriteBoard(*position.state, writer);
  WriteBombs(*position.state, writer);
  WriteAgents(*position.state, position.viewer, writer);
  WriteOwnStatistics(*position.state, position.viewer, writer);
}

int LastStep(const GameSettings& settings) { return std::max(1, settings.max_steps - 1); }

}  // namespace

Cell MarkedCell(const Position& position, int after) {
  const auto agent = static_cast<std::size_t>((position.viewer + after) % kAgentCount);
  const AgentState& marked = position.state->agents[agent];
  return marked.alive && position.visible.Has(marked.cell) ? Cell{marked.cell} : kNoCell;
}

void EncodePlanes(const GameSettings& settings, const Position& position,
                  std::span<float, kPlanesSize> planes) {
  PlaneWriter writer(planes, position.visible);
  WriteAllButStep(position, writer);
  writer.FillWith(kStep, std::min(1.0F, static_cast<float>(position.state->step) /
                                            static_cast<float>(LastStep(settings))));
}

void EncodePlaneCounts(const Position& position, std::span<std::int8_t, kPlaneCountsSize> counts) {
  PlaneWriter writer(counts, position.visible);
  WriteAllButStep(position, writer);
  writer.FillWith(kStep, static_cast<std::int8_t>(position.state->step / kStepBase));
  writer.FillWith(kStep + 1, static_cast<std::int8_t>(position.state->step % kStepBase));
}

std::array<float, kPlaneCount + 1> PlaneScales(const GameSettings& settings) {
  std::array<float, kPlaneCount + 1> scales{};
  std::ranges::transform(kWholes, scales.begin(),
                         [](int whole) { return 1.0F / static_cast<float>(whole); });
  scales[kStep] = static_cast<float>(kStepBase) / static_cast<float>(LastStep(settings));
  scales[kStep + 1] = 1.0F / static_cast<float>(LastStep(settings));
  return scales;
}

}  // namespace powderkeg

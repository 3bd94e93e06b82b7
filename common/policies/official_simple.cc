#include "common/policies/official_simple.h"

#include <algorithm>
#include <array>
#include <optional>

#include "common/policies/cross.h"

namespace powderkeg {

namespace {

constexpr int kRememberedCount = 6;
constexpr int kSearchDepth = 10;  // Manhattan distance within which the search knows cells
constexpr int kEnemyRadius = 3;   // path length within which enemies are approached
constexpr int kItemRadius = 2;

// The cells the search considers around a cell: within kSearchDepth, and inside a square whose
// upper ends are exclusive, so that row 10 is missing from row 0 and column 10 from column 0.
consteval std::array<BitBoard, kCellCount> MakeSearchAreas() {
  std::array<BitBoard, kCellCount> areas;
  for (Cell from = 0; from < kCellCount; ++from) {
    const int end_row = std::min(kBoardSize, RowOf(from) + kSearchDepth);
    const int end_column = std::min(kBoardSize, ColumnOf(from) + kSearchDepth);
    for (Cell to = 0; to < kCellCount; ++to) {
      if (RowOf(to) < end_row && ColumnOf(to) < end_column &&
          ManhattanDistance(from, to) <= kSearchDepth) {
        areas[from].Add(to);
      }
    }
  }
  return areas;
}

constexpr auto kSearchAreas = MakeSearchAreas();

// A few directions in an order that matters.
struct DirectionList {
  std::array<Direction, 5> values{};
  std::uint32_t count = 0;

  void Add(Direction direction) { values[count++] = direction; }
  [[nodiscard]] const Direction* begin() const { return values.data(); }
  [[nodiscard]] const Direction* end() const { return values.data() + count; }
  // Uniform; kNone from an empty list.
  [[nodiscard]] Direction Draw(Rng& rng) const {
    return count == 0 ? Direction::kNone : values[count == 1 ? 0 : rng.Below(count)];
  }
  template <typename Predicate>
  void KeepIf(Predicate&& keep) {
    const auto last = std::remove_if(values.begin(), values.begin() + count,
                                     [&](Direction direction) { return !keep(direction); });
    count = static_cast<std::uint32_t>(last - values.begin());
  }
};

// Directions from which a bomb threatens the own cell: the strength of the strongest bomb of each,
// in the order in which they were first seen.
struct Threats {
  DirectionList order;
  std::array<int, 5> strength{};  // by Direction; 0: no threat

  void Add(Direction direction, int bomb_strength) {
    int& known = strength[static_cast<int>(direction)];
    if (known == 0) order.Add(direction);
    known = std::max(known, bomb_strength);
  }
  [[nodiscard]] int From(Direction direction) const {
    return strength[static_cast<int>(direction)];
  }
};

BitBoard LinesThrough(Cell cell) { return CrossOf(cell, kBoardSize); }

Cell LastOf(BitBoard cells) {
  Cell last = kNoCell;
  ForEachCell(cells, [&](Cell cell) { last = cell; });
  return last;
}

// One decision: what the rules read of the view, worked out once.
class Turn {
 public:
  explicit Turn(const PolicyView& view);

  // The rules in their order.
  [[nodiscard]] Action Choose(PolicyMemory& memory, Rng& rng);

 private:
  void SeeAgents();
  void SeeBombs();
  // Cells one step further than `frontier` on the search's way; removes them from `open`.
  [[nodiscard]] BitBoard Expand(BitBoard frontier, BitBoard& open) const;
  void MeasureDistances();

  // Rule 1.
  [[nodiscard]] Threats FindThreats() const;
  [[nodiscard]] bool IsWithinWalk(Cell target, int steps) const;
  [[nodiscard]] Direction Evade(const Threats& threats, Rng& rng) const;
  [[nodiscard]] Direction Escape(const Threats& threats) const;
  [[nodiscard]] bool IsStuck(Cell start, int strength) const;
  // Rules 2 and 5: nullopt where the official code raises an exception.
  [[nodiscard]] std::optional<bool> MayBomb() const;
  // Rules 3, 4 and 6.
  [[nodiscard]] Cell NearestEnemy() const;
  [[nodiscard]] Cell NearestItem() const;
  [[nodiscard]] Direction FirstStepTowards(Cell goal, Rng& rng);
  [[nodiscard]] Cell DrawPredecessorAtOne(Cell goal, Rng& rng);
  [[nodiscard]] Cell DrawPredecessorAtTwo(Cell goal, Rng& rng) const;
  // Rule 7.
  [[nodiscard]] Direction Wander(PolicyMemory& memory, Rng& rng) const;

  [[nodiscard]] BitBoard Target(Direction direction) const {
    return BitBoard::Of(cell_).Shifted(direction);
  }
  [[nodiscard]] bool IsThreatened(Direction direction) const {
    return (Target(direction) & threatened_).Any();
  }

  const PolicyView& view_;
  const State& state_;
  const AgentState& self_;
  const Cell cell_;
  BitBoard agents_;  // visible, living
  BitBoard enemies_;
  BitBoard passable_;    // agents other than enemies, items, passages
  BitBoard passages_;    // cells shown as passage
  BitBoard nodes_;       // cells the search knows: also wood, bombs, enemies
  BitBoard bombs_;       // visible
  BitBoard threatened_;  // in line with a visible bomb at distance <= its strength
  std::array<BitBoard, kEnemyRadius + 1> at_distance_;  // nodes by length of the shortest path
  // The cell at distance two whose predecessor was drawn last, and that.
  Cell drawn_goal_ = kNoCell;
  Cell drawn_predecessor_ = kNoCell;
};

Turn::Turn(const PolicyView& view)
    : view_(view), state_(view.state), self_(view.state.agents[view.self]), cell_(self_.cell) {
  SeeAgents();
  SeeBombs();
  const BitBoard blocked = state_.rigid | state_.Flames();
  nodes_ = view.visible & kSearchAreas[cell_] & ~blocked;
  const BitBoard occupied = blocked | state_.wood | (state_.bomb_cells & ~agents_);
  passable_ = view.visible & ~(occupied | enemies_);
  passages_ = passable_ & ~(agents_ | state_.Items());
}

void Turn::SeeAgents() {
  for (int id = 0; id < kAgentCount; ++id) {
    const AgentState& agent = state_.agents[id];
    if (!agent.alive || !view_.visible.Has(agent.cell)) continue;
    agents_.Add(agent.cell);
    if (AreEnemies(view_.settings.mode, view_.self, id)) enemies_.Add(agent.cell);
  }
}

void Turn::SeeBombs() {
  bombs_ = state_.bomb_cells & view_.visible;
  for (const Bomb& bomb : state_.Bombs()) {
    if (bombs_.Has(bomb.cell)) threatened_ |= CrossOf(bomb.cell, bomb.blast_strength);
  }
}

BitBoard Turn::Expand(BitBoard frontier, BitBoard& open) const {
  const BitBoard next = (frontier & passable_).Neighbours() & open;
  open ^= next;
  return next;
}

void Turn::MeasureDistances() {
  BitBoard open = nodes_;
  open.Remove(cell_);
  at_distance_[0] = BitBoard::Of(cell_);
  for (std::size_t distance = 1; distance < at_distance_.size(); ++distance) {
    at_distance_[distance] = Expand(at_distance_[distance - 1], open);
  }
}

bool Turn::IsWithinWalk(Cell target, int steps) const {
  BitBoard open = nodes_;
  BitBoard frontier = BitBoard::Of(cell_);
  for (int distance = 0; frontier.Any() && distance <= steps; ++distance) {
    if (frontier.Has(target)) return true;
    frontier = Expand(frontier, open);
  }
  return false;
}

// Only bombs in the own row or column threaten, at most their strength of steps away.
Threats Turn::FindThreats() const {
  Threats threats;
  if (!threatened_.Has(cell_)) return threats;
  ForEachCell(bombs_ & LinesThrough(cell_), [&](Cell cell) {
    const int strength = state_.BombAt(cell)->blast_strength;
    if (ManhattanDistance(cell, cell_) > strength || !IsWithinWalk(cell, strength)) return;
    if (cell == cell_) {
      for (const Direction direction :
           {Direction::kRight, Direction::kLeft, Direction::kUp, Direction::kDown}) {
        threats.Add(direction, strength);
      }
    } else if (RowOf(cell) == RowOf(cell_)) {
      threats.Add(cell > cell_ ? Direction::kRight : Direction::kLeft, strength);
    } else {
      threats.Add(cell > cell_ ? Direction::kDown : Direction::kUp, strength);
    }
  });
  return threats;
}

Direction Turn::Evade(const Threats& threats, Rng& rng) const {
  if (threats.order.count == kDirections.size()) return Escape(threats);
  DirectionList safe;
  for (const Direction direction : kDirections) {
    const BitBoard target = Target(direction);
    if (threats.From(direction) == 0 && (target & (passable_ | ~view_.visible)).Any()) {
      safe.Add(direction);
    }
  }
  if (safe.count == 0) {
    safe = threats.order;
    safe.KeepIf([&](Direction direction) { return Target(direction).Any(); });
  }
  return safe.Draw(rng);
}

// The first direction from which one gets out of the line or the range of its bomb.
Direction Turn::Escape(const Threats& threats) const {
  for (const Direction direction : threats.order) {
    const BitBoard target = Target(direction);
    if ((target & passable_).Empty()) continue;
    if (!IsStuck(target.First(), threats.From(direction))) return direction;
  }
  return Direction::kNone;
}

// Whether all that can be walked to from `start`, not through the own cell, lies in its row and
// column within `strength`.
bool Turn::IsStuck(Cell start, int strength) const {
  const BitBoard in_reach = CrossOf(start, strength);
  BitBoard open = passable_;
  open.Remove(cell_);
  BitBoard frontier = BitBoard::Of(start);
  while (frontier.Any()) {
    if ((frontier & ~in_reach).Any()) return false;
    open &= ~frontier;
    frontier = frontier.Neighbours() & open;
  }
  return true;
}

// Whether there is a passage to flee to: off the own lines, or further than the own strength.
std::optional<bool> Turn::MayBomb() const {
  if (self_.ammo < 1) return false;
  const BitBoard passages = passages_ & nodes_;
  if (passages.Empty()) return std::nullopt;
  BitBoard open = nodes_;
  open.Remove(cell_);
  BitBoard frontier = BitBoard::Of(cell_);
  BitBoard refuges = passages & ~LinesThrough(cell_);
  for (int distance = 0; frontier.Any(); ++distance) {
    if (distance > self_.blast_strength) refuges = passages;
    if ((frontier & refuges).Any()) return true;
    frontier = Expand(frontier, open);
  }
  return false;
}

// Of equally near ones the last by id.
Cell Turn::NearestEnemy() const {
  for (std::size_t distance = 1; distance <= kEnemyRadius; ++distance) {
    const BitBoard near = at_distance_[distance] & enemies_;
    if (near.Empty()) continue;
    for (int id = kAgentCount - 1; id >= 0; --id) {
      const AgentState& agent = state_.agents[id];
      if (agent.alive && near.Has(agent.cell)) return agent.cell;
    }
  }
  return kNoCell;
}

// Of equally near ones the last kind, and of that the last cell.
Cell Turn::NearestItem() const {
  const BitBoard items = state_.Items() & passable_ & ~agents_;
  for (std::size_t distance = 1; distance <= kItemRadius; ++distance) {
    const BitBoard near = at_distance_[distance] & items;
    if (near.Empty()) continue;
    const BitBoard kick = near & state_.item_high & state_.item_low;
    const BitBoard range = near & state_.item_high;
    return LastOf(kick.Any() ? kick : range.Any() ? range : near);
  }
  return kNoCell;
}

// The search keeps the first predecessor that reaches a cell; each further one at the same distance
// takes its place with probability 1/2.
class PredecessorDraw {
 public:
  void Offer(Cell cell, Rng& rng) {
    if (cell_ == kNoCell || rng.Below(2) == 0) cell_ = cell;
  }
  [[nodiscard]] Cell cell() const { return cell_; }

 private:
  Cell cell_ = kNoCell;
};

// `goal` is at distance 1 to 3.
Direction Turn::FirstStepTowards(Cell goal, Rng& rng) {
  if (at_distance_[3].Has(goal)) goal = DrawPredecessorAtTwo(goal, rng);
  if (at_distance_[2].Has(goal)) goal = DrawPredecessorAtOne(goal, rng);
  const auto leads = [&](Direction direction) { return Target(direction).Has(goal); };
  return *std::ranges::find_if(kDirections, leads);
}

// Two goals may share a predecessor at distance two: what was drawn for it stands.
Cell Turn::DrawPredecessorAtOne(Cell goal, Rng& rng) {
  if (goal == drawn_goal_) return drawn_predecessor_;
  const BitBoard candidates = BitBoard::Of(goal).Neighbours() & at_distance_[1] & passable_;
  PredecessorDraw draw;
  for (const Direction direction : kDirections) {
    const BitBoard found = Target(direction) & candidates;
    if (found.Any()) draw.Offer(found.First(), rng);
  }
  drawn_goal_ = goal;
  drawn_predecessor_ = draw.cell();
  return drawn_predecessor_;
}

// Cells at distance two are offered in the order in which the search found them.
Cell Turn::DrawPredecessorAtTwo(Cell goal, Rng& rng) const {
  BitBoard candidates = BitBoard::Of(goal).Neighbours() & at_distance_[2] & passable_;
  PredecessorDraw draw;
  for (const Direction first : kDirections) {
    const BitBoard middle = Target(first) & at_distance_[1] & passable_;
    for (const Direction second : kDirections) {
      const BitBoard found = middle.Shifted(second) & candidates;
      if (found.Empty()) continue;
      candidates ^= found;
      draw.Offer(found.First(), rng);
    }
  }
  return draw.cell();
}

bool Remembers(const PolicyMemory& memory, BitBoard target) {
  const Cell cell = target.First();
  const auto end = memory.recent.begin() + memory.recent_count;
  return std::find(memory.recent.begin(), end, RememberedPosition(RowOf(cell), ColumnOf(cell))) !=
         end;
}

void Remember(Cell cell, PolicyMemory& memory) {
  auto& recent = memory.recent;
  if (memory.recent_count == kRememberedCount) {
    std::copy(recent.begin() + 1, recent.end(), recent.begin());
    --memory.recent_count;
  }
  recent[memory.recent_count++] = RememberedPosition(RowOf(cell), ColumnOf(cell));
}

Direction Turn::Wander(PolicyMemory& memory, Rng& rng) const {
  DirectionList choices;
  for (const Direction direction :
       {Direction::kNone, Direction::kLeft, Direction::kRight, Direction::kUp, Direction::kDown}) {
    if ((Target(direction) & passable_ & ~threatened_).Any()) choices.Add(direction);
  }
  DirectionList fresh = choices;
  fresh.KeepIf([&](Direction direction) { return !Remembers(memory, Target(direction)); });
  if (fresh.count > 0) choices = fresh;
  if (choices.count > 1) {
    choices.KeepIf([](Direction direction) { return direction != Direction::kNone; });
  }
  Remember(cell_, memory);
  return choices.Draw(rng);
}

Action Turn::Choose(PolicyMemory& memory, Rng& rng) {
  const Threats threats = FindThreats();
  if (threats.order.count > 0) return ActionOf(Evade(threats, rng));
  MeasureDistances();
  if ((at_distance_[1] & enemies_).Any()) {
    const auto may_bomb = MayBomb();
    if (!may_bomb) return Action::kStop;
    if (*may_bomb) return Action::kBomb;
  }
  if (const Cell enemy = NearestEnemy(); enemy != kNoCell) {
    const Direction direction = FirstStepTowards(enemy, rng);
    const auto number = static_cast<std::uint8_t>(direction);
    if (memory.previous_direction != number || rng.Below(2) == 0) {
      memory.previous_direction = number;
      return ActionOf(direction);
    }
  }
  if (const Cell item = NearestItem(); item != kNoCell) {
    return ActionOf(FirstStepTowards(item, rng));
  }
  if ((at_distance_[1] & state_.wood).Any()) {
    return MayBomb().value_or(false) ? Action::kBomb : Action::kStop;
  }
  if (const BitBoard wood = at_distance_[2] & state_.wood; wood.Any()) {
    const Direction direction = FirstStepTowards(LastOf(wood), rng);
    if (!IsThreatened(direction)) return ActionOf(direction);
  }
  return ActionOf(Wander(memory, rng));
}

}  // namespace

Action DecideOfficialSimple(const PolicyView& view, PolicyMemory& memory, Rng& rng) {
  return Turn(view).Choose(memory, rng);
}

void ObserveOfficialSimple(Cell before, Cell after, PolicyMemory& memory) {
  if (after != before) Remember(before, memory);
}

}  // namespace powderkeg

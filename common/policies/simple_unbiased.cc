#include "common/policies/simple_unbiased.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "common/policies/cross.h"

namespace powderkeg {

namespace {

constexpr int kRememberedCount = 4;
constexpr int kApproachDistance = 14;  // Manhattan, of enemies worth approaching
constexpr int kItemDistance = 5;       // rows and columns, of items worth collecting

constexpr std::uint32_t kRowBits = (1u << kBoardSize) - 1;

// Bits of the columns first..last, clipped to the board; 0 if there is none.
std::uint32_t ColumnBits(int first, int last) {
  first = std::max(first, 0);
  last = std::min(last, kBoardSize - 1);
  return first > last ? 0 : (kRowBits >> (kBoardSize - 1 - last)) & ~((1u << first) - 1);
}

// Per cell those near enough for their items to be collected.
constexpr auto kItemWindows = [] {
  std::array<BitBoard, kCellCount> windows;
  for (Cell center = 0; center < kCellCount; ++center) {
    for (Cell cell = 0; cell < kCellCount; ++cell) {
      const int rows = RowOf(cell) - RowOf(center);
      const int columns = ColumnOf(cell) - ColumnOf(center);
      if (std::max(rows, -rows) <= kItemDistance && std::max(columns, -columns) <= kItemDistance) {
        windows[center].Add(cell);
      }
    }
  }
  return windows;
}();

// One decision: what the rules read of the view, worked out once.
class Turn {
 public:
  Turn(const PolicyView& view, const PolicyTraits& traits);

  // The rules in their order. `memory` is read only.
  [[nodiscard]] Action Choose(const PolicyMemory& memory, Rng& rng) const;

  [[nodiscard]] int row() const { return row_; }
  [[nodiscard]] int column() const { return column_; }

 private:
  void SeeAgents(const PolicyView& view);
  void SeeBombs(const PolicyView& view);
  // The first move of the search's path from the own cell to `target`; kNone if there is none.
  [[nodiscard]] Direction StepTowards(Cell target) const;
  [[nodiscard]] Direction FirstMove(BitBoard neighbours) const;
  // Whether the move leads to a walkable cell outside `danger`. The own cell is never walkable.
  [[nodiscard]] bool CanStep(Direction direction, BitBoard danger) const;

  // Rule 1; kNone to go on with rule 3.
  [[nodiscard]] Direction Flee() const;
  [[nodiscard]] std::uint32_t ScannedColumns() const;
  [[nodiscard]] Direction StepToRefuge(int row, std::uint32_t columns) const;
  // Rule 2; nullopt to go on with rule 3.
  [[nodiscard]] std::optional<Action> Attack(const PolicyMemory& memory, Rng& rng) const;
  [[nodiscard]] Direction Approach() const;
  // Rule 3; kNone to go on with rule 4.
  [[nodiscard]] Direction CollectItem() const;
  [[nodiscard]] Direction FirstSafeStep(BitBoard targets) const;
  // Rule 4; kNone to stop.
  [[nodiscard]] Direction Wander(const PolicyMemory& memory, Rng& rng) const;

  const PolicyView& view_;
  const PolicyTraits& traits_;
  const AgentState& self_;
  int row_;
  int column_;
  BitBoard agents_;     // cells of the visible living agents
  BitBoard walkable_;   // visible passages and items
  int danger_ = 0;      // steps until the first explosion that covers the own cell; 0: none
  BitBoard exploding_;  // cells covered by visible bombs of life 1
  BitBoard burning_;    // and of life 1 or 2
  std::array<bool, kAgentCount> enemies_{};  // living, visible, within kApproachDistance
  int nearest_enemy_ = kApproachDistance + 1;
};

Turn::Turn(const PolicyView& view, const PolicyTraits& traits)
    : view_(view),
      traits_(traits),
      self_(view.state.agents[view.self]),
      row_(RowOf(self_.cell)),
      column_(ColumnOf(self_.cell)) {
  SeeAgents(view);
  SeeBombs(view);
  const State& state = view.state;
  walkable_ =
      view.visible & ~(state.rigid | state.wood | state.bomb_cells | state.Flames() | agents_);
}

void Turn::SeeAgents(const PolicyView& view) {
  for (int id = 0; id < kAgentCount; ++id) {
    const AgentState& agent = view.state.agents[id];
    if (!agent.alive || !view.visible.Has(agent.cell)) continue;
    agents_.Add(agent.cell);
    if (!AreEnemies(view.settings.mode, view.self, id)) continue;
    const int distance = ManhattanDistance(self_.cell, agent.cell);
    if (distance > kApproachDistance) continue;
    enemies_[id] = true;
    nearest_enemy_ = std::min(nearest_enemy_, distance);
  }
}

void Turn::SeeBombs(const PolicyView& view) {
  for (const Bomb& bomb : view.state.Bombs()) {
    if (!view.visible.Has(bomb.cell)) continue;
    const BitBoard cross = CrossOf(bomb.cell, bomb.blast_strength - 1);
    if (cross.Has(self_.cell) && (danger_ == 0 || bomb.life < danger_)) danger_ = bomb.life;
    if (bomb.life <= 2) burning_ |= cross;
    if (bomb.life <= 1) exploding_ |= cross;
  }
}

// The search expands the cells of one distance grouped by their first move, in the order of
// kSearchOrder, and a cell keeps the first parent that reaches it. So its path begins with the
// earliest move, in that order, with which any shortest path begins: the own neighbours that a
// flood from the target reaches first.
Direction Turn::StepTowards(Cell target) const {
  BitBoard frontier = BitBoard::Of(target);
  BitBoard open = walkable_;
  const BitBoard goals = BitBoard::Of(self_.cell).Neighbours() & (open | frontier);
  if (goals.Empty()) return Direction::kNone;
  for (;;) {
    const BitBoard reached = frontier & goals;
    if (reached.Any()) return FirstMove(reached);
    frontier = frontier.Neighbours() & open;
    if (frontier.Empty()) return Direction::kNone;
    open ^= frontier;
  }
}

Direction Turn::FirstMove(BitBoard neighbours) const {
  for (const Direction direction : kSearchOrder) {
    if (neighbours.Has(NeighbourOrSelf(self_.cell, direction))) return direction;
  }
  return Direction::kNone;
}

bool Turn::CanStep(Direction direction, BitBoard danger) const {
  return (walkable_ & ~danger).Has(NeighbourOrSelf(self_.cell, direction));
}

Action Turn::Choose(const PolicyMemory& memory, Rng& rng) const {
  Direction direction = Direction::kNone;
  if (danger_ > 0) {
    direction = Flee();
  } else if (self_.ammo > 0) {
    if (const auto action = Attack(memory, rng)) return *action;
  }
  if (direction == Direction::kNone) direction = CollectItem();
  if (direction == Direction::kNone) direction = Wander(memory, rng);
  return ActionOf(direction);
}

// The scan leaves a row at the first column outside [column - danger, column + danger): these are
// the columns it looks at before.
std::uint32_t Turn::ScannedColumns() const {
  const std::uint32_t near = ColumnBits(column_ - danger_, column_ + danger_ - 1);
  std::uint32_t scanned = 0;
  for (const int column : traits_.column_order) {
    if ((near >> column & 1) == 0) break;
    scanned |= 1u << column;
  }
  return scanned;
}

Direction Turn::Flee() const {
  const std::uint32_t scanned = ScannedColumns();
  if (scanned == 0) return Direction::kNone;
  const BitBoard refuges = (walkable_ | agents_) & ~(exploding_ | BitBoard::Of(self_.cell));
  for (const int row : traits_.row_order) {
    if (row < row_ - danger_ || row >= row_ + danger_) continue;
    const int width = danger_ - (row < row_ ? row_ - row : row - row_);
    const std::uint32_t columns =
        scanned & refuges.ColumnsOf(row) & ColumnBits(column_ - width, column_ + width);
    if (columns == 0) continue;
    const Direction direction = StepToRefuge(row, columns);
    if (direction == Direction::kNone) continue;
    return CanStep(direction, exploding_) ? direction : Direction::kNone;
  }
  return Direction::kNone;
}

// The step towards the first reachable of these cells, in the order of the scan.
Direction Turn::StepToRefuge(int row, std::uint32_t columns) const {
  for (const int column : traits_.column_order) {
    if ((columns >> column & 1) == 0) continue;
    const Direction direction = StepTowards(CellAt(row, column));
    if (direction != Direction::kNone) return direction;
  }
  return Direction::kNone;
}

// Whether the last positions alternate between two. With two remembered positions the original
// compares with an entry not yet written.
bool InLoop(const PolicyMemory& memory) {
  const auto& recent = memory.recent;
  switch (memory.recent_count) {
    case 0:
    case 1: return true;
    case 2: return false;
    case 3: return recent[0] == recent[2];
    default: return recent[0] == recent[2] && recent[1] == recent[3];
  }
}

std::optional<Action> Turn::Attack(const PolicyMemory& memory, Rng& rng) const {
  if (nearest_enemy_ <= 1) return Action::kBomb;
  if (nearest_enemy_ <= kApproachDistance) {
    if (InLoop(memory)) return ActionOf(kDirections[rng.Below(4)]);
    const Direction direction = Approach();
    if (direction != Direction::kNone && CanStep(direction, burning_)) return ActionOf(direction);
  }
  const BitBoard beside = BitBoard::Of(self_.cell).Neighbours();
  if ((beside & view_.state.wood).Any()) return Action::kBomb;
  return std::nullopt;
}

Direction Turn::Approach() const {
  for (const std::uint8_t id : traits_.agent_order) {
    if (!enemies_[id]) continue;
    const Direction direction = StepTowards(view_.state.agents[id].cell);
    if (direction != Direction::kNone) return direction;
  }
  return Direction::kNone;
}

Direction Turn::CollectItem() const {
  BitBoard items = view_.state.Items() & walkable_ & kItemWindows[self_.cell];
  if (items.Empty()) return Direction::kNone;
  BitBoard open = walkable_;
  BitBoard frontier = BitBoard::Of(self_.cell).Neighbours() & open;
  while (frontier.Any()) {
    const BitBoard reached = frontier & items;
    if (reached.Any()) {
      const Direction direction = FirstSafeStep(reached);
      if (direction != Direction::kNone) return direction;
      items ^= reached;
      if (items.Empty()) return Direction::kNone;
    }
    open ^= frontier;
    frontier = frontier.Neighbours() & open;
  }
  return Direction::kNone;
}

// The step towards the first of the targets, in the order of the scan, to which a safe step leads.
Direction Turn::FirstSafeStep(BitBoard targets) const {
  for (const int row : traits_.row_order) {
    const std::uint32_t columns = targets.ColumnsOf(row);
    if (columns == 0) continue;
    for (const int column : traits_.column_order) {
      if ((columns >> column & 1) == 0) continue;
      const Direction direction = StepTowards(CellAt(row, column));
      if (CanStep(direction, exploding_)) return direction;
    }
  }
  return Direction::kNone;
}

bool Remembers(const PolicyMemory& memory, Cell cell) {
  const auto end = memory.recent.begin() + memory.recent_count;
  return std::find(memory.recent.begin(), end, RememberedPosition(RowOf(cell), ColumnOf(cell))) !=
         end;
}

Direction Turn::Wander(const PolicyMemory& memory, Rng& rng) const {
  std::array<Direction, 4> shuffled = kDirections;
  rng.Shuffle(std::span<Direction>(shuffled));
  std::array<Direction, 4> kept{};
  int count = 0;
  for (const Direction direction : shuffled) {
    if (CanStep(direction, exploding_)) kept[count++] = direction;
  }
  if (count == 0) return Direction::kNone;
  // The original means to move remembered cells to the end, but it appends what follows the removed
  // one instead, and looks at the cursor's place again.
  int cursor = 0;
  for (int turn = 0; turn < count; ++turn) {
    const auto place = kept.begin() + cursor;
    if (Remembers(memory, Neighbour(self_.cell, *place))) {
      std::copy(place + 1, kept.begin() + count, place);
      if (cursor < count - 1) kept[count - 1] = *place;
    } else {
      ++cursor;
    }
  }
  return kept[rng.Below(static_cast<std::uint32_t>(std::min(2, count)))];
}

void Remember(int row, int column, PolicyMemory& memory) {
  auto& recent = memory.recent;
  if (memory.recent_count == kRememberedCount) {
    std::copy(recent.begin() + 1, recent.begin() + kRememberedCount, recent.begin());
    --memory.recent_count;
  }
  recent[memory.recent_count++] = RememberedPosition(row, column);
}

}  // namespace

Action DecideSimpleUnbiased(const PolicyView& view, const PolicyTraits& traits,
                            PolicyMemory& memory, Rng& rng) {
  const Turn turn(view, traits);
  const Action action = turn.Choose(memory, rng);
  int row = turn.row();
  int column = turn.column();
  switch (action) {
    case Action::kUp: --row; break;
    case Action::kDown: ++row; break;
    case Action::kLeft: --column; break;
    case Action::kRight: ++column; break;
    case Action::kStop:
    case Action::kBomb: break;
  }
  Remember(row, column, memory);
  return action;
}

void ObserveSimpleUnbiased(Cell after, PolicyMemory& memory) {
  Remember(RowOf(after), ColumnOf(after), memory);
}

}  // namespace powderkeg

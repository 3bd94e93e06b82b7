#include "common/pommerman/belief.h"

#include <algorithm>
#include <optional>
#include <tuple>

#include "common/pommerman/step.h"

namespace powderkeg {

struct Sight {
  explicit Sight(const Observation& observation);
  // What Observe(settings, state, viewer) shows, without writing it down.
  Sight(const GameSettings& settings, const State& state, AgentId viewer);

  AgentId self;
  std::uint16_t step;
  Message message;  // the mate's, radio
  std::array<bool, kAgentCount> alive;
  AgentState own;
  BitBoard visible;
  BitBoard rigid;
  BitBoard wood;
  BitBoard item_low;
  BitBoard item_high;
  std::array<BitBoard, 3> newest_flames;  // cells by the life of their newest flame
  std::array<Cell, kAgentCount> agents;   // kNoCell where not seen alive
  std::array<Bomb, kMaxBombs> bombs;      // without owner, by cell
  int bomb_count = 0;

 private:
  void LookAt(Cell cell, const Observation& observation);
  void AddBomb(Cell cell, int life, std::uint8_t blast_strength, Direction direction);
};

Sight::Sight(const Observation& observation)
    : self(observation.self),
      step(observation.step),
      message(observation.message),
      alive(observation.alive),
      own{.cell = observation.position,
          .ammo = observation.ammo,
          .blast_strength = observation.blast_strength,
          .alive = observation.alive[observation.self],
          .can_kick = observation.can_kick} {
  agents.fill(kNoCell);
  for (Cell cell = 0; cell < kCellCount; ++cell) {
    if (observation.board[cell] != CellValue::kFog) LookAt(cell, observation);
  }
  if (own.alive) agents[self] = own.cell;
}

void Sight::LookAt(Cell cell, const Observation& observation) {
  visible.Add(cell);
  const CellValue value = observation.board[cell];
  if (value == CellValue::kRigid) rigid.Add(cell);
  if (value == CellValue::kWood) wood.Add(cell);
  if (value == CellValue::kExtraBomb || value == CellValue::kKick) item_low.Add(cell);
  if (value == CellValue::kIncreaseRange || value == CellValue::kKick) item_high.Add(cell);
  if (value >= CellValue::kAgent0) agents[static_cast<int>(value) - 10] = cell;
  if (const int life = observation.flame_life[cell]; life > 0) {
    newest_flames[std::min(life, 3) - 1].Add(cell);
  }
  if (observation.bomb_blast_strength[cell] > 0) {
    AddBomb(cell, observation.bomb_life[cell], observation.bomb_blast_strength[cell],
            observation.bomb_moving_direction[cell]);
  }
}

void Sight::AddBomb(Cell cell, int life, std::uint8_t blast_strength, Direction direction) {
  if (bomb_count == kMaxBombs) return;
  Bomb& bomb = bombs[bomb_count++];
  bomb.cell = static_cast<std::uint8_t>(cell);
  bomb.life = static_cast<std::int8_t>(life);
  bomb.blast_strength = blast_strength;
  bomb.set_direction(direction);
}

Sight::Sight(const GameSettings& settings, const State& state, AgentId viewer)
    : self(viewer),
      step(state.step),
      message(settings.mode == Mode::kTeamRadio ? state.messages[TeamMateOf(settings.mode, viewer)]
                                                : Message{}),
      own(state.agents[viewer]),
      visible(VisibleCells(settings, own.cell)) {
  agents.fill(kNoCell);
  BitBoard covered = state.bomb_cells | state.Flames();
  for (AgentId id = 0; id < kAgentCount; ++id) {
    const AgentState& agent = state.agents[id];
    alive[id] = agent.alive;
    if (!agent.alive || !visible.Has(agent.cell)) continue;
    agents[id] = agent.cell;
    covered.Add(agent.cell);
  }
  const BitBoard open = visible & ~covered;
  rigid = state.rigid & open;
  wood = state.wood & open;
  const BitBoard items = state.VisibleItems() & open;
  item_low = state.item_low & items;
  item_high = state.item_high & items;
  BitBoard newer;
  for (int life = 2; life >= 0; --life) {
    newest_flames[life] = state.flames[life] & visible & ~newer;
    newer |= state.flames[life];
  }
  for (const Bomb& bomb : state.Bombs()) {
    if (visible.Has(bomb.cell)) {
      AddBomb(bomb.cell, bomb.life, bomb.blast_strength, bomb.direction());
    }
  }
  std::sort(bombs.begin(), bombs.begin() + bomb_count,
            [](const Bomb& a, const Bomb& b) { return a.cell < b.cell; });
}

namespace {

// The furthest a bomb gets in one step: a deflected one, diagonally.
constexpr int kBombStride = 2;

const Bomb* BombIn(const Sight& sight, Cell cell) {
  const auto end = sight.bombs.begin() + sight.bomb_count;
  const auto found = std::find_if(sight.bombs.begin(), end,
                                  [cell](const Bomb& bomb) { return bomb.cell == cell; });
  return found == end ? nullptr : &*found;
}

// The direction between neighbours; kNone for any other two cells.
Direction DirectionBetween(Cell from, Cell to) {
  for (const Direction direction : kDirections) {
    if (Neighbour(from, direction) == to) return direction;
  }
  return Direction::kNone;
}

// A move out of sight, if the agent's cell is in view by now.
Action UnseenMove(const State& state, const Sight& sight, Cell cell) {
  if (!sight.visible.Has(cell)) return Action::kStop;
  for (const Direction direction : kDirections) {
    const Cell target = Neighbour(cell, direction);
    if (target != kNoCell && !sight.visible.Has(target) && state.Walkable().Has(target)) {
      return ActionOf(direction);
    }
  }
  return Action::kStop;
}

// What the agent did, as far as it shows. Puts right in `state` what it must have been able to do,
// and where it came from if it comes out of the fog.
Action InferAction(const Sight& sight, AgentId id, State& state) {
  AgentState& agent = state.agents[id];
  const Cell seen = sight.agents[id];
  if (seen == kNoCell) return UnseenMove(state, sight, agent.cell);
  if (const Direction direction = DirectionBetween(agent.cell, seen);
      direction != Direction::kNone) {
    return ActionOf(direction);
  }
  agent.cell = static_cast<std::uint8_t>(seen);
  const Bomb* bomb = BombIn(sight, seen);
  if (bomb == nullptr || bomb->life != kFreshBombLife || state.bomb_cells.Has(seen)) {
    return Action::kStop;
  }
  agent.ammo = std::max(agent.ammo, std::uint8_t{1});
  agent.blast_strength = bomb->blast_strength;
  return Action::kBomb;
}

// Whoever got past a bomb that holds it up in the prediction can kick.
State PredictKicks(const GameSettings& settings, const Sight& sight, const JointAction& actions,
                   State predicted, State& before) {
  for (AgentId id = 0; id < kAgentCount; ++id) {
    const Cell seen = sight.agents[id];
    if (seen == kNoCell || predicted.agents[id].cell == seen) continue;
    if (before.agents[id].can_kick) continue;
    before.agents[id].can_kick = true;
    State kicked = before;
    Step(settings, actions, kicked);
    before.agents[id].can_kick = kicked.agents[id].cell == seen;
    if (before.agents[id].can_kick) predicted = kicked;
  }
  return predicted;
}

// The position after the moves that were seen; `before` is the believed position they were made in.
State Predict(const GameSettings& settings, const Sight& sight, State& before) {
  JointAction actions{};
  for (AgentId id = 0; id < kAgentCount; ++id) {
    if (before.agents[id].alive) actions[id] = InferAction(sight, id, before);
  }
  State predicted = before;
  Step(settings, actions, predicted);
  return PredictKicks(settings, sight, actions, predicted, before);
}

// Older flames below the newest are those predicted.
void SeeFlames(const Sight& sight, State& state) {
  BitBoard older;  // cells whose newest flame is of a higher life
  for (int life = 2; life >= 0; --life) {
    const BitBoard seen = sight.newest_flames[life];
    const BitBoard unknown = ~sight.visible | older;
    state.flames[life] = (state.flames[life] & unknown) | seen;
    older |= seen;
  }
}

void SeeCells(const Sight& sight, State& state) {
  state.rigid = (state.rigid & ~sight.visible) | sight.rigid;
  state.wood = (state.wood & ~sight.visible) | sight.wood;
  state.item_low = (state.item_low & ~sight.visible) | sight.item_low;
  state.item_high = (state.item_high & ~sight.visible) | sight.item_high;
}

void SeeAgents(const Sight& sight, State& state) {
  for (AgentId id = 0; id < kAgentCount; ++id) {
    AgentState& agent = state.agents[id];
    agent.alive = sight.alive[id];
    if (sight.agents[id] != kNoCell) agent.cell = static_cast<std::uint8_t>(sight.agents[id]);
  }
  state.agents[sight.self] = sight.own;
}

// Finds out whose the bombs in view are, and which of those out of sight there still are. Bombs are
// told apart by life and strength; who is out of step with the prediction gets its ammo corrected.
class BombMatch {
 public:
  BombMatch(const Sight& sight, AgentId self, const State& before, State& state)
      : sight_(sight), self_(self), state_(state) {
    AddCandidates(before);
  }

  void Run();

 private:
  struct Candidate {
    Bomb bomb;
    bool exploded;  // in the prediction; its ammo is back
    bool taken = false;
  };

  void AddCandidates(const State& before);
  void Assign(Bomb& seen);
  [[nodiscard]] Candidate* Find(const Bomb& seen, int distance);
  [[nodiscard]] AgentId LikelyOwner(const Bomb& seen) const;
  void ChangeAmmo(AgentId id, int change);
  void KeepUnseen();
  void SortByAge();

  const Sight& sight_;
  AgentId self_;
  State& state_;
  std::array<Candidate, 2 * kMaxBombs> candidates_;
  int candidate_count_ = 0;
};

// The predicted bombs, and those that exploded in the prediction: both lists are in the order of
// age, so that what exploded is what is missing from the second.
void BombMatch::AddCandidates(const State& before) {
  auto next = state_.Bombs().begin();
  for (const Bomb& old : before.Bombs()) {
    Bomb expected = old;
    --expected.life;
    const bool survives = next != state_.Bombs().end() && next->life == expected.life &&
                          next->blast_strength == expected.blast_strength &&
                          next->owner() == expected.owner();
    candidates_[candidate_count_++] = {survives ? *next : expected, !survives};
    if (survives) ++next;
  }
  for (; next != state_.Bombs().end(); ++next) candidates_[candidate_count_++] = {*next, false};
}

void BombMatch::Run() {
  state_.RemoveBombs(BitBoard::All());
  std::array<Bomb, kMaxBombs> bombs = sight_.bombs;
  for (int i = 0; i < sight_.bomb_count; ++i) Assign(bombs[i]);
  KeepUnseen();
  SortByAge();
}

void BombMatch::Assign(Bomb& seen) {
  Candidate* match = Find(seen, 0);
  if (match == nullptr) match = Find(seen, kBombStride);
  if (match == nullptr) {
    seen.set_owner(LikelyOwner(seen));
    ChangeAmmo(seen.owner(), -1);
  } else {
    match->taken = true;
    seen.set_owner(match->bomb.owner());
    if (match->exploded) ChangeAmmo(seen.owner(), -1);
  }
  state_.AddBomb(seen);
}

// The nearest candidate of the same life and strength within `distance`.
BombMatch::Candidate* BombMatch::Find(const Bomb& seen, int distance) {
  Candidate* best = nullptr;
  for (int i = 0; i < candidate_count_; ++i) {
    Candidate& candidate = candidates_[i];
    if (candidate.taken || candidate.bomb.life != seen.life ||
        candidate.bomb.blast_strength != seen.blast_strength) {
      continue;
    }
    const int away = ManhattanDistance(candidate.bomb.cell, seen.cell);
    if (away > distance) continue;
    best = &candidate;
    distance = away - 1;
  }
  return best;
}

// Own bombs are never news.
AgentId BombMatch::LikelyOwner(const Bomb& seen) const {
  AgentId likely = (self_ + 1) % kAgentCount;
  int nearest = kCellCount;
  for (AgentId id = 0; id < kAgentCount; ++id) {
    const AgentState& agent = state_.agents[id];
    const int distance = ManhattanDistance(agent.cell, seen.cell);
    if (id == self_ || !agent.alive || distance >= nearest) continue;
    likely = id;
    nearest = distance;
  }
  return likely;
}

void BombMatch::ChangeAmmo(AgentId id, int change) {
  if (id == self_) return;
  std::uint8_t& ammo = state_.agents[id].ammo;
  ammo = static_cast<std::uint8_t>(std::clamp(ammo + change, 0, kMaxAmmo));
}

// A bomb predicted in view but not seen there has exploded.
void BombMatch::KeepUnseen() {
  for (int i = 0; i < candidate_count_; ++i) {
    const Candidate& candidate = candidates_[i];
    if (candidate.taken || candidate.exploded) continue;
    if (sight_.visible.Has(candidate.bomb.cell)) {
      ChangeAmmo(candidate.bomb.owner(), 1);
    } else if (state_.bomb_count < kMaxBombs) {
      state_.AddBomb(candidate.bomb);
    }
  }
}

// Bombs of one step are laid in the order of the agents.
void BombMatch::SortByAge() {
  std::ranges::sort(state_.Bombs(), {}, [](const Bomb& bomb) {
    return std::tuple(bomb.life, bomb.owner(), bomb.cell);
  });
}

// Where another agent can be that is not seen.
BitBoard HidingPlaces(const State& state, BitBoard visible) {
  return state.Walkable() & ~state.Items() & ~visible;
}

// The nearest of the cells; `from` itself if there is none.
Cell Nearest(BitBoard cells, Cell from) {
  Cell best = from;
  int nearest = kCellCount;
  ForEachCell(cells, [&](Cell cell) {
    const int distance = ManhattanDistance(from, cell);
    if (distance >= nearest) return;
    best = cell;
    nearest = distance;
  });
  return best;
}

// Moves living agents out of sight from where they cannot be: cells in view, in flames or of
// others.
void HideAgents(const Sight& sight, State& state) {
  BitBoard taken = sight.visible | state.Flames();
  for (AgentId id = 0; id < kAgentCount; ++id) {
    AgentState& agent = state.agents[id];
    if (!agent.alive || sight.agents[id] != kNoCell) continue;
    if (taken.Has(agent.cell)) {
      agent.cell =
          static_cast<std::uint8_t>(Nearest(HidingPlaces(state, sight.visible), agent.cell));
    }
    taken.Add(agent.cell);
  }
}

// Agent i starts in corner i. Where corners are permuted, whose corner we start in has ours.
void PlaceAtStart(const GameSettings& settings, const Sight& sight, State& state) {
  const int last = settings.board_size - 2;
  std::array<Cell, kAgentCount> corners = {CellAt(1, 1), CellAt(last, 1), CellAt(last, last),
                                           CellAt(1, last)};
  if (settings.mode == Mode::kOneVsOne) std::swap(corners[1], corners[2]);
  const auto own = std::ranges::find(corners, Cell{sight.own.cell});
  if (own != corners.end()) std::swap(*own, corners[sight.self]);
  for (AgentId id = 0; id < kAgentCount; ++id) {
    state.agents[id].cell = static_cast<std::uint8_t>(corners[id]);
  }
}

}  // namespace

void Belief::Observe(const Observation& observation) { See(Sight(observation)); }

void Belief::Observe(const State& truth, AgentId viewer) { See(Sight(settings_, truth, viewer)); }

void Belief::See(const Sight& sight) {
  self_ = sight.self;
  if (ever_seen_.Empty()) PlaceAtStart(settings_, sight, state_);
  State before;
  if (ever_seen_.Any() && sight.step == state_.step + 1) {
    before = state_;
    state_ = Predict(settings_, sight, before);
  }
  state_.step = sight.step;
  SeeAgents(sight, state_);
  SeeCells(sight, state_);
  SeeFlames(sight, state_);
  BombMatch(sight, self_, before, state_).Run();
  HideAgents(sight, state_);
  Collapse(settings_, state_);
  state_.agents[self_].alive = sight.own.alive;
  visible_ = sight.visible;
  ever_seen_ |= visible_;
  if (settings_.mode == Mode::kTeamRadio) Listen(sight.message);
}

void Belief::Listen(const Message& message) {
  AgentState& mate = state_.agents[TeamMateOf(settings_.mode, self_)];
  mate_.Hear(state_.step, message);
  if (!mate.alive) return;
  if (visible_.Has(mate.cell)) {
    mate_.See(state_.step, mate.cell);
  } else if (const std::optional<Cell> cell = mate_.cell()) {
    const BitBoard places = HidingPlaces(state_, visible_) | BitBoard::Of(mate.cell);
    mate.cell = static_cast<std::uint8_t>(Nearest(places, *cell));
  }
}

Message Belief::Report(Action action) const {
  return EncodeReport(state_.step, state_.agents[self_].cell, action);
}

}  // namespace powderkeg

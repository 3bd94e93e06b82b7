#include "tests/pommerman/reference_step.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace powderkeg {
namespace {

// Values of the official board.
constexpr int kPassage = 0;
constexpr int kRigid = 1;
constexpr int kWood = 2;
constexpr int kBomb = 3;
constexpr int kFlames = 4;
constexpr int kExtraBomb = 6;
constexpr int kIncreaseRange = 7;
constexpr int kKick = 8;

struct Place {
  int row = 0;
  int column = 0;
  friend auto operator<=>(const Place&, const Place&) = default;
};

struct AgentModel {
  int id = 0;
  Place place = {};
  Place wish = {};
  int ammo = 0;
  int strength = 0;
  bool alive = false;
  bool can_kick = false;
  int linked_bomb = -1;
};

struct BombModel {
  int owner = 0;
  Place place = {};
  Place wish = {};
  int life = 0;
  int strength = 0;
  int direction = 0;
  int linked_agent = -1;
};

struct FlameModel {
  Place place = {};
  int life = 0;
};

bool OnBoard(Place place) {
  return place.row >= 0 && place.row < 11 && place.column >= 0 && place.column < 11;
}

Place Next(Place place, int direction) {
  switch (direction) {
    case 1: return {place.row - 1, place.column};
    case 2: return {place.row + 1, place.column};
    case 3: return {place.row, place.column - 1};
    case 4: return {place.row, place.column + 1};
    default: return place;
  }
}

// The official environment's data and its step.
class Environment {
 public:
  Environment(const GameSettings& settings, const State& state) : settings_(settings) {
    LoadBoard(state);
    LoadLists(state);
  }

  void Play(const JointAction& actions) {
    AgeFlames();
    WishAgents(actions);
    WishBombs();
    Cross();
    ShareTargets();
    if (Kick(actions)) UndoLate();
    Commit();
    Tick();
    Explode();
    Redraw();
  }

  [[nodiscard]] State Stored(const State& before) const {
    State state;
    state.step = static_cast<std::uint16_t>(before.step + 1);
    for (int row = 0; row < 11; ++row) {
      for (int column = 0; column < 11; ++column) StoreCell({row, column}, state);
    }
    for (const auto& [place, item] : hidden_) state.SetItem(CellOf(place), ItemOf(item));
    for (const FlameModel& flame : flames_) state.flames[flame.life].Add(CellOf(flame.place));
    for (const BombModel& bomb : bombs_) {
      Bomb stored{.cell = static_cast<std::uint8_t>(CellOf(bomb.place)),
                  .life = static_cast<std::int8_t>(bomb.life),
                  .blast_strength = static_cast<std::uint8_t>(bomb.strength)};
      stored.set_owner(bomb.owner);
      stored.set_direction(static_cast<Direction>(bomb.direction));
      state.AddBomb(stored);
    }
    for (const AgentModel& agent : agents_) {
      state.agents[agent.id] = {.cell = static_cast<std::uint8_t>(CellOf(agent.place)),
                                .ammo = static_cast<std::uint8_t>(agent.ammo),
                                .blast_strength = static_cast<std::uint8_t>(agent.strength),
                                .alive = agent.alive,
                                .can_kick = agent.can_kick};
    }
    return state;
  }

 private:
  static Cell CellOf(Place place) { return CellAt(place.row, place.column); }
  static Item ItemOf(int value) { return static_cast<Item>(value - kExtraBomb + 1); }

  int& At(Place place) { return board_[place.row][place.column]; }
  [[nodiscard]] int At(Place place) const { return board_[place.row][place.column]; }
  static bool IsPowerUp(int value) { return value >= kExtraBomb && value <= kKick; }
  [[nodiscard]] bool StopsBombs(Place place) const {
    return !OnBoard(place) || IsPowerUp(At(place)) || At(place) == kRigid || At(place) == kWood;
  }

  void LoadBoard(const State& state) {
    for (Cell cell = 0; cell < kCellCount; ++cell) {
      const Place place = {RowOf(cell), ColumnOf(cell)};
      At(place) = static_cast<int>(state.ValueAt(cell));
      const bool covered = At(place) == kWood || At(place) == kFlames;
      if (covered && state.ItemAt(cell) != Item::kNone) {
        hidden_[place] = kExtraBomb + static_cast<int>(state.ItemAt(cell)) - 1;
      }
    }
  }

  void LoadLists(const State& state) {
    for (int life = 0; life < 3; ++life) {
      ForEachCell(state.flames[life], [&](Cell cell) {
        flames_.push_back({{RowOf(cell), ColumnOf(cell)}, life});
      });
    }
    for (const Bomb& bomb : state.Bombs()) {
      bombs_.push_back({.owner = bomb.owner(),
                        .place = {RowOf(bomb.cell), ColumnOf(bomb.cell)},
                        .life = bomb.life,
                        .strength = bomb.blast_strength,
                        .direction = static_cast<int>(bomb.direction())});
    }
    for (int id = 0; id < 4; ++id) {
      const AgentState& agent = state.agents[id];
      agents_.push_back({.id = id,
                         .place = {RowOf(agent.cell), ColumnOf(agent.cell)},
                         .ammo = agent.ammo,
                         .strength = agent.blast_strength,
                         .alive = agent.alive,
                         .can_kick = agent.can_kick});
    }
  }

  void StoreCell(Place place, State& state) const {
    const int value = At(place);
    if (value == kRigid) state.rigid.Add(CellOf(place));
    if (value == kWood) state.wood.Add(CellOf(place));
    if (IsPowerUp(value)) state.SetItem(CellOf(place), ItemOf(value));
  }

  void AgeFlames() {
    std::vector<FlameModel> remaining;
    for (FlameModel flame : flames_) {
      if (flame.life > 0) {
        --flame.life;
        remaining.push_back(flame);
        continue;
      }
      const auto item = hidden_.find(flame.place);
      At(flame.place) = item == hidden_.end() ? kPassage : item->second;
      if (item != hidden_.end()) hidden_.erase(item);
    }
    flames_ = remaining;
    for (const FlameModel& flame : flames_) At(flame.place) = kFlames;
  }

  void WishAgents(const JointAction& actions) {
    for (AgentModel& agent : agents_) {
      if (!agent.alive) continue;
      At(agent.place) = kPassage;
      agent.wish = agent.place;
      const int action = static_cast<int>(actions[agent.id]);
      if (action == 5) {
        const bool free = std::ranges::count(bombs_, agent.place, &BombModel::place) == 0;
        if (free && agent.ammo > 0) {
          --agent.ammo;
          bombs_.push_back(
              {.owner = agent.id, .place = agent.place, .life = 10, .strength = agent.strength});
        }
      } else if (action != 0) {
        const Place next = Next(agent.place, action);
        if (OnBoard(next) && At(next) != kRigid && At(next) != kWood) agent.wish = next;
      }
    }
  }

  void WishBombs() {
    for (BombModel& bomb : bombs_) {
      At(bomb.place) = kPassage;
      bomb.wish = bomb.place;
      if (bomb.direction == 0) continue;
      const Place next = Next(bomb.place, bomb.direction);
      if (!StopsBombs(next)) bomb.wish = next;
    }
  }

  void Cross() {
    struct Holder {
      bool is_agent;
      std::size_t index;
    };
    std::map<std::pair<Place, Place>, Holder> holders;
    for (std::size_t i = 0; i < agents_.size(); ++i) {
      AgentModel& agent = agents_[i];
      if (!agent.alive || agent.wish == agent.place) continue;
      const auto border = std::minmax(agent.place, agent.wish);
      const auto [holder, is_new] = holders.insert({border, {true, i}});
      if (is_new) continue;
      agent.wish = agent.place;
      AgentModel& earlier = agents_[holder->second.index];
      earlier.wish = earlier.place;
    }
    for (std::size_t i = 0; i < bombs_.size(); ++i) {
      BombModel& bomb = bombs_[i];
      if (bomb.wish == bomb.place) continue;
      const auto border = std::minmax(bomb.place, bomb.wish);
      const auto [holder, is_new] = holders.insert({border, {false, i}});
      if (is_new) continue;
      bomb.wish = bomb.place;
      if (holder->second.is_agent) continue;
      BombModel& earlier = bombs_[holder->second.index];
      earlier.wish = earlier.place;
    }
  }

  void ShareTargets() {
    for (const AgentModel& agent : agents_) {
      if (agent.alive) ++agent_count_[agent.wish];
    }
    for (const BombModel& bomb : bombs_) ++bomb_count_[bomb.wish];
    for (bool changed = true; changed;) {
      changed = false;
      for (AgentModel& agent : agents_) {
        if (!agent.alive || agent.wish == agent.place) continue;
        if (agent_count_[agent.wish] <= 1 && bomb_count_[agent.wish] <= 1) continue;
        agent.wish = agent.place;
        ++agent_count_[agent.place];
        changed = true;
      }
      for (BombModel& bomb : bombs_) {
        if (bomb.wish == bomb.place) continue;
        if (agent_count_[bomb.wish] <= 1 && bomb_count_[bomb.wish] <= 1) continue;
        bomb.wish = bomb.place;
        ++bomb_count_[bomb.place];
        changed = true;
      }
    }
  }

  bool Kick(const JointAction& actions) {
    std::vector<std::pair<int, Place>> bomb_changes;
    std::vector<std::pair<int, Place>> agent_changes;
    for (int i = 0; i < static_cast<int>(bombs_.size()); ++i) {
      BombModel& bomb = bombs_[i];
      const Place wish = bomb.wish;
      if (agent_count_[wish] == 0) continue;
      const auto agent = std::ranges::find_if(
          agents_, [&](const AgentModel& one) { return one.alive && one.wish == wish; });
      if (agent == agents_.end()) continue;
      if (agent->place == wish) {
        if (bomb.place != wish) bomb_changes.push_back({i, bomb.place});
        continue;
      }
      const int direction = static_cast<int>(actions[agent->id]);
      const Place target = Next(wish, direction);
      const bool allowed = agent->can_kick && OnBoard(target) && agent_count_[target] == 0 &&
                           bomb_count_[target] == 0 && !StopsBombs(target);
      if (!allowed) {
        bomb_changes.push_back({i, bomb.place});
        agent_changes.push_back({agent->id, agent->place});
        continue;
      }
      bomb_count_[wish] = 0;
      bomb_changes.push_back({i, target});
      bomb.direction = direction;
      bomb.linked_agent = agent->id;
      agent->linked_bomb = i;
    }
    for (const auto& [index, place] : bomb_changes) {
      bombs_[index].wish = place;
      ++bomb_count_[place];
    }
    for (const auto& [id, place] : agent_changes) {
      agents_[id].wish = place;
      ++agent_count_[place];
    }
    return !bomb_changes.empty() || !agent_changes.empty();
  }

  void UndoLate() {
    for (bool changed = true; changed;) {
      changed = false;
      for (AgentModel& agent : agents_) {
        if (!agent.alive || agent.wish == agent.place) continue;
        if (agent_count_[agent.wish] <= 1 && bomb_count_[agent.wish] == 0) continue;
        if (agent.linked_bomb >= 0) {
          BombModel& bomb = bombs_[agent.linked_bomb];
          bomb.wish = bomb.place;
          ++bomb_count_[bomb.place];
          bomb.linked_agent = -1;
          agent.linked_bomb = -1;
        }
        agent.wish = agent.place;
        ++agent_count_[agent.place];
        changed = true;
      }
      for (BombModel& bomb : bombs_) {
        if (bomb.wish == bomb.place && bomb.linked_agent < 0) continue;
        if (bomb_count_[bomb.wish] <= 1 && agent_count_[bomb.wish] == 0) continue;
        bomb.wish = bomb.place;
        ++bomb_count_[bomb.place];
        if (bomb.linked_agent >= 0) {
          AgentModel& agent = agents_[bomb.linked_agent];
          agent.wish = agent.place;
          ++agent_count_[agent.place];
          agent.linked_bomb = -1;
          bomb.linked_agent = -1;
        }
        changed = true;
      }
    }
  }

  void Commit() {
    for (BombModel& bomb : bombs_) {
      if (bomb.wish == bomb.place && bomb.linked_agent < 0) bomb.direction = 0;
      bomb.place = bomb.wish;
    }
    for (AgentModel& agent : agents_) {
      if (!agent.alive || agent.wish == agent.place) continue;
      agent.place = agent.wish;
      int& value = At(agent.place);
      if (value == kExtraBomb) agent.ammo = std::min(agent.ammo + 1, 10);
      if (value == kIncreaseRange) {
        agent.strength = std::min(agent.strength + 1, settings_.blast_strength_cap);
      }
      if (value == kKick) agent.can_kick = true;
      if (IsPowerUp(value)) value = kPassage;
    }
  }

  void Tick() {
    for (std::size_t i = 0; i < bombs_.size(); ++i) {
      BombModel& bomb = bombs_[i];
      --bomb.life;
      if (bomb.life == 0) {
        exploding_.insert(i);
      } else if (At(bomb.place) == kFlames) {
        bomb.life = 0;
        exploding_.insert(i);
      }
    }
  }

  void Explode() {
    std::set<std::size_t> gone;
    while (!exploding_.empty()) {
      for (const std::size_t i : exploding_) {
        BurnFrom(bombs_[i]);
        AgentModel& owner = agents_[bombs_[i].owner];
        owner.ammo = std::min(owner.ammo + 1, 10);
        gone.insert(i);
      }
      exploding_.clear();
      for (std::size_t i = 0; i < bombs_.size(); ++i) {
        if (!gone.contains(i) && burning_.contains(bombs_[i].place)) exploding_.insert(i);
      }
    }
    std::vector<BombModel> remaining;
    for (std::size_t i = 0; i < bombs_.size(); ++i) {
      if (!gone.contains(i)) remaining.push_back(bombs_[i]);
    }
    bombs_ = remaining;
  }

  void BurnFrom(const BombModel& bomb) {
    burning_.insert(bomb.place);
    for (int direction = 1; direction <= 4; ++direction) {
      Place place = bomb.place;
      for (int distance = 1; distance < bomb.strength; ++distance) {
        place = Next(place, direction);
        if (!OnBoard(place) || At(place) == kRigid) break;
        burning_.insert(place);
        if (At(place) == kWood) break;
      }
    }
  }

  void Redraw() {
    for (const BombModel& bomb : bombs_) At(bomb.place) = kBomb;
    for (const Place place : burning_) flames_.push_back({place, 2});
    for (const FlameModel& flame : flames_) At(flame.place) = kFlames;
    for (AgentModel& agent : agents_) {
      if (!agent.alive) continue;
      if (At(agent.place) == kFlames) {
        agent.alive = false;
      } else {
        At(agent.place) = 10 + agent.id;
      }
    }
  }

  const GameSettings& settings_;
  std::array<std::array<int, 11>, 11> board_{};
  std::vector<AgentModel> agents_;
  std::vector<BombModel> bombs_;
  std::vector<FlameModel> flames_;
  std::map<Place, int> hidden_;
  std::map<Place, int> agent_count_;
  std::map<Place, int> bomb_count_;
  std::set<std::size_t> exploding_;
  std::set<Place> burning_;
};

}  // namespace

void ReferenceStep(const GameSettings& settings, const JointAction& actions, State& state) {
  Environment environment(settings, state);
  environment.Play(actions);
  state = environment.Stored(state);
}

}  // namespace powderkeg

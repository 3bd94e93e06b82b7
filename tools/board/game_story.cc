#include "tools/board/game_story.h"

#include <cmath>
#include <vector>

#include "common/pommerman/step.h"

namespace powderkeg {
namespace {

using Json = nlohmann::json;

char ItemCharacter(Item item) {
  switch (item) {
    case Item::kExtraBomb: return 'b';
    case Item::kIncreaseRange: return 'r';
    case Item::kKick: return 'k';
    case Item::kNone: break;
  }
  return '.';
}

char CellCharacter(const State& state, Cell cell) {
  for (int life = static_cast<int>(state.flames.size()) - 1; life >= 0; --life) {
    if (state.flames[life].Has(cell)) return static_cast<char>('1' + life);
  }
  if (state.rigid.Has(cell)) return '#';
  if (state.wood.Has(cell)) return '+';
  return ItemCharacter(state.ItemAt(cell));
}

std::string BoardCharacters(const State& state) {
  std::string board;
  for (Cell cell = 0; cell < kCellCount; ++cell) board += CellCharacter(state, cell);
  return board;
}

std::vector<int> BombNumbers(const State& state) {
  std::vector<int> numbers;
  for (const Bomb& bomb : state.Bombs()) {
    const int direction = static_cast<int>(bomb.direction());
    numbers.insert(numbers.end(),
                   {bomb.cell, bomb.life, bomb.blast_strength, bomb.owner(), direction});
  }
  return numbers;
}

std::vector<int> AgentNumbers(const State& state) {
  std::vector<int> numbers;
  for (const AgentState& agent : state.agents) {
    numbers.insert(numbers.end(), {agent.cell, agent.ammo, agent.blast_strength,
                                   int{agent.can_kick}, int{agent.alive}});
  }
  return numbers;
}

std::string MoveCharacters(const State& state, const JointAction& actions) {
  std::string moves;
  for (AgentId id = 0; id < kAgentCount; ++id) {
    const int action = static_cast<int>(actions[id]);
    moves += state.agents[id].alive ? static_cast<char>('0' + action) : '-';
  }
  return moves;
}

Json NoNews() {
  return {{"frames", Json::array()}, {"moves", Json::array()}, {"deaths", Json::array()}};
}

const char* ModeName(Mode mode) {
  switch (mode) {
    case Mode::kFreeForAll: return "free for all";
    case Mode::kTeam: return "teams";
    case Mode::kTeamRadio: return "teams with radio";
    case Mode::kOneVsOne: return "one against one";
  }
  return "";
}

}  // namespace

GameStory::GameStory(const GameSettings& settings, const State& start)
    : settings_(settings), state_(start), news_(NoNews()) {
  TellFrame();
}

void GameStory::Play(const JointAction& actions, const std::array<Message, kAgentCount>& messages) {
  const State before = state_;
  news_["moves"].push_back(MoveCharacters(before, actions));
  Step(settings_, actions, messages, state_);
  const StepEvents events = watcher_.Watch(settings_, before, actions, state_);
  Collapse(settings_, state_);
  ++steps_;
  TellDeaths(before, events);
  TellFrame();
}

void GameStory::TellFrame() {
  Json frame = {BoardCharacters(state_), BombNumbers(state_), AgentNumbers(state_)};
  if (settings_.mode == Mode::kTeamRadio) {
    std::vector<int> words;
    for (const Message& message : state_.messages) {
      words.insert(words.end(), message.begin(), message.end());
    }
    frame.push_back(words);
  }
  news_["frames"].push_back(std::move(frame));
}

void GameStory::TellDeaths(const State& before, const StepEvents& events) {
  for (AgentId id = 0; id < kAgentCount; ++id) {
    if (!before.agents[id].alive || state_.agents[id].alive) continue;
    news_["deaths"].push_back({steps_, id, events.killers[id]});
  }
}

Json GameStory::TakeNews() { return std::exchange(news_, NoNews()); }

Json HeadJson(const std::string& name, const GameSettings& settings,
              const std::array<std::string, kAgentCount>& players) {
  return {{"name", name},
          {"mode", ModeName(settings.mode)},
          {"teams", IsTeamMode(settings.mode)},
          {"size", settings.board_size},
          {"radius", settings.view_radius},
          {"seats", SeatCount(settings.mode)},
          {"players", players}};
}

Json DecisionsJson(std::span<const Decision> decisions) {
  Json list = Json::array();
  for (const Decision& decision : decisions) {
    Json row = {decision.step};
    for (const int visits : decision.visits) row.push_back(visits);
    row.push_back(std::round(1000.0 * decision.value) / 1000.0);
    list.push_back(std::move(row));
  }
  return list;
}

std::string GameJson(const StoredGame& stored) {
  const RecordedGame& game = stored.game;
  GameStory story(game.settings, game.start);
  for (const RecordedStep& step : game.steps) story.Play(step.actions, step.messages);
  Json json = HeadJson(game.id, game.settings, stored.players);
  json.update(story.TakeNews());
  json["searches"] = Json::array();
  for (const Track& track : stored.tracks)
    json["searches"].push_back(DecisionsJson(track.decisions));
  json["result"] = ResultName(game.result);
  json["winners"] = game.winners;
  return json.dump();
}

const char* ResultName(Result result) {
  switch (result) {
    case Result::kIncomplete: return "incomplete";
    case Result::kWin: return "win";
    case Result::kTie: return "tie";
  }
  return "";
}

}  // namespace powderkeg

#include "tools/board/play_room.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

#include "actors/play/game.h"
#include "common/base/check.h"
#include "tools/board/game_story.h"
#include "tools/board/person.h"

namespace powderkeg {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostGames = 16;
constexpr AgentId kPerson = 0;

GameSetup SetupOf(const PlaySettings& settings, std::uint64_t number) {
  GameSetup setup;
  setup.settings = settings.game;
  setup.start = settings.start;
  setup.seed = Rng(settings.seed).Split(number).Next();
  setup.seats[kPerson].searches = true;
  for (AgentId seat = 1; seat < SeatCount(settings.game.mode); ++seat) {
    const AgentSpec& agent = settings.opponents[seat - 1];
    const bool searches = agent.kind != AgentSpec::Kind::kRuleBased;
    setup.seats[seat] = {.searches = searches,
                         .policy = agent.policy,
                         .teaches = searches ? Teaches::kSearch : Teaches::kNothing};
  }
  return setup;
}

std::array<std::string, kAgentCount> PlayersOf(const PlaySettings& settings) {
  std::array<std::string, kAgentCount> players = {"you"};
  for (AgentId seat = 1; seat < SeatCount(settings.game.mode); ++seat) {
    players[seat] = settings.opponents[seat - 1].text;
  }
  return players;
}

Json AdviceJson(const SearchResult& advice) {
  Json json = {{"best", static_cast<int>(advice.best)},
               {"visits", advice.visits},
               {"priors", advice.priors},
               {"values", advice.values},
               {"value", advice.value},
               {"expected", Json::array()}};
  for (AgentId id = 0; id < kAgentCount; ++id) {
    const bool known = Has(advice.expected_agents, id);
    json["expected"].push_back(known ? static_cast<int>(advice.expected_actions[id]) : -1);
  }
  return json;
}

HttpReply JsonReply(const Json& json) { return {.body = json.dump()}; }

}  // namespace

// One game. One thread at a time.
class PlayRoom::Table {
 public:
  Table(const PlayRoom& room, std::uint64_t number)
      : settings_(room.settings_.game),
        adviser_(room.ModelFor(room.settings_.adviser)),
        person_(room.settings_.adviser.search) {
    GamePlan plan{.ticket = number, .setup = SetupOf(room.settings_, number), .agents = {}};
    plan.agents[kPerson] = {&person_, adviser_};
    for (AgentId seat = 1; seat < kAgentCount; ++seat) {
      if (!plan.setup.seats[seat].searches) continue;
      const AgentSpec& agent = room.settings_.opponents[seat - 1];
      agents_.push_back(MakeAgent(agent));
      plan.agents[seat] = {agents_.back().get(), room.ModelFor(agent)};
    }
    game_.Start(plan);
    story_.emplace(settings_, game_.state());
  }

  [[nodiscard]] int step() const { return static_cast<int>(game_.record().actions.size()); }
  [[nodiscard]] bool over() const { return over_; }
  [[nodiscard]] bool waits_for_person() const {
    return !over_ && game_.state().agents[kPerson].alive;
  }

  void Play(Action action) {
    person_.Decide(action);
    for (const int before = step(); !over_ && step() == before;) {
      batches_.Clear();
      over_ = !game_.Gather(batches_);
      if (over_) return;
      batches_.Evaluate(settings_);
      game_.Scatter(batches_);
    }
  }

  [[nodiscard]] Json Advice() { return AdviceJson(person_.Advice(*adviser_.evaluator)); }

  // What the page has not been told.
  [[nodiscard]] Json TakeNews() {
    const GameRecord& record = game_.record();
    for (; told_ < record.actions.size(); ++told_) story_->Play(record.actions[told_]);
    Json json = story_->TakeNews();
    for (AgentId id = 0; id < kAgentCount; ++id) {
      const std::span<const Decision> decisions = record.tracks[id].decisions;
      json["searches"].push_back(DecisionsJson(decisions.subspan(told_decisions_[id])));
      told_decisions_[id] = decisions.size();
    }
    json["step"] = step();
    json["over"] = over_;
    json["result"] = ResultName(record.outcome.result);
    json["winners"] = record.outcome.winners;
    return json;
  }

  std::uint64_t last_call = 0;

 private:
  const GameSettings settings_;
  const Model adviser_;
  Person person_;
  std::vector<std::unique_ptr<Agent>> agents_;  // the others that are no rule-based policies
  Game game_;
  EvaluationBatches batches_;
  bool over_ = false;
  std::optional<GameStory> story_;
  std::size_t told_ = 0;
  std::array<std::size_t, kAgentCount> told_decisions_{};
};

PlayRoom::PlayRoom(PlaySettings settings) : settings_(std::move(settings)) {
  models_[""] = MakeModel("", settings_.loader);
  const auto load = [&](const AgentSpec& agent) {
    Model& model = models_[agent.model_file];
    if (model.evaluator == nullptr) model = MakeModel(agent.model_file, settings_.loader);
  };
  load(settings_.adviser);
  std::ranges::for_each(settings_.opponents, load);
}

PlayRoom::~PlayRoom() = default;

const Model& PlayRoom::ModelFor(const AgentSpec& agent) const {
  return models_.at(agent.model_file);
}

HttpReply PlayRoom::Begin() {
  const std::lock_guard lock(mutex_);
  // A server of the official protocol plays one game at a time.
  const bool one_by_one = std::ranges::any_of(settings_.opponents, [](const AgentSpec& agent) {
    return agent.kind == AgentSpec::Kind::kForeign;
  });
  if (tables_.size() >= (one_by_one ? 1 : kMostGames)) {
    const auto oldest = std::ranges::min_element(
        tables_, {}, [](const auto& table) { return table.second->last_call; });
    tables_.erase(oldest);
  }
  const std::uint64_t number = next_game_++;
  auto table = std::make_unique<Table>(*this, number);
  table->last_call = ++calls_;
  Json json = HeadJson(StrCat("game ", number), settings_.game, PlayersOf(settings_));
  json.update(table->TakeNews());
  json["game"] = number;
  tables_.emplace(number, std::move(table));
  return JsonReply(json);
}

HttpReply PlayRoom::Move(std::uint64_t game, int step, Action action) {
  const std::lock_guard lock(mutex_);
  HttpReply refusal;
  Table* const table = TableAt(game, step, refusal);
  if (table == nullptr) return refusal;
  try {
    table->Play(action);
  } catch (const Error& error) {  // of an agent that is a server
    tables_.erase(game);
    return HttpError(502, error.what());
  }
  return JsonReply(table->TakeNews());
}

HttpReply PlayRoom::Hint(std::uint64_t game, int step) {
  const std::lock_guard lock(mutex_);
  HttpReply refusal;
  Table* const table = TableAt(game, step, refusal);
  if (table == nullptr) return refusal;
  if (!table->waits_for_person()) return HttpError(409, "the dead get no hints");
  return JsonReply(table->Advice());
}

PlayRoom::Table* PlayRoom::TableAt(std::uint64_t game, int step, HttpReply& refusal) {
  const auto found = tables_.find(game);
  if (found == tables_.end()) {
    refusal = HttpError(404, StrCat("game ", game, ": never begun, or forgotten since"));
    return nullptr;
  }
  Table& table = *found->second;
  table.last_call = ++calls_;
  if (table.over()) {
    refusal = HttpError(409, StrCat("game ", game, " is over"));
  } else if (table.step() != step) {
    refusal = HttpError(409, StrCat("step ", step, ": expected ", table.step()));
  } else {
    return &table;
  }
  return nullptr;
}

}  // namespace powderkeg

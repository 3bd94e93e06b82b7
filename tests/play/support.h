#pragma once

// Fakes and shortcuts for the tests of games.

#include <memory>
#include <optional>
#include <vector>

#include "actors/play/game.h"
#include "actors/play/game_loop.h"
#include "actors/play/search_agent.h"
#include "common/pommerman/observation.h"

namespace powderkeg {

// Asks `questions` times a move, one position each, then plays randomly. Checks that the calls come
// in the order that Agent promises, and notes a decision for each move.
class AskingAgent final : public Agent {
 public:
  explicit AskingAgent(int questions) : questions_(questions) {}

  void StartGame(const GameSettings& /*settings*/, AgentId self, Rng rng) override {
    self_ = self;
    rng_ = rng;
  }
  void Begin(const Observation& observation) override {
    CHECK(!asking_ && observation.self == self_ && observation.alive[self_]);
    heard.push_back(observation.message);
    state_.agents[self_].cell = observation.position;
    left_ = questions_;
    value_sum_ = 0;
    action_ = static_cast<Action>(rng_.Below(kActionCount));
  }
  bool Gather(EvaluationBatch& batch) override {
    CHECK(!asking_);
    if (left_ == 0) return false;
    --left_;
    asking_ = true;
    slot_ = batch.Add({&state_, self_});
    return true;
  }
  void Scatter(const EvaluationBatch& batch) override {
    CHECK(asking_);
    asking_ = false;
    value_sum_ += batch.evaluation(slot_).value;
  }
  [[nodiscard]] Action action() const override { return action_; }
  [[nodiscard]] Message words() const override {
    return {static_cast<std::uint8_t>(1 + self_), static_cast<std::uint8_t>(action_)};
  }
  [[nodiscard]] std::optional<Decision> decision() const override {
    Decision decision;
    decision.visits[static_cast<std::size_t>(action_)] = 1;
    decision.value = questions_ == 0 ? 0 : value_sum_ / static_cast<float>(questions_);
    return decision;
  }

  std::vector<Message> heard;  // the mate's words in all observations

 private:
  int questions_;
  AgentId self_ = 0;
  Rng rng_;
  State state_;
  int left_ = 0;
  bool asking_ = false;
  std::size_t slot_ = 0;
  float value_sum_ = 0;
  Action action_ = Action::kStop;
};

// Answers every question with one value; counts its batches.
class ConstantEvaluator final : public Evaluator {
 public:
  explicit ConstantEvaluator(float value) : value_(value) {}
  void Evaluate(const GameSettings& /*settings*/, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    CHECK(positions.size() == evaluations.size() && !positions.empty());
    ++batches;
    for (Evaluation& evaluation : evaluations) {
      evaluation.policy.fill(1.0F / kActionCount);
      evaluation.value = value_;
    }
  }
  [[nodiscard]] std::string name() const override { return "constant"; }

  int batches = 0;

 private:
  float value_;
};

inline GameSetup SetupOfSeats(std::array<Seat, kAgentCount> seats, std::uint64_t seed,
                              const GameSettings& settings = {}) {
  return {settings, {BoardGenerator::kOfficial, StartCorners::kPermuted}, seats, seed};
}

inline constexpr Seat kSearching = {
    .searches = true, .teaches = Teaches::kSearch, .measured = true};
inline constexpr Seat kSimpleUnbiasedSeat = {.searches = false,
                                             .policy = PolicyKind::kSimpleUnbiased};

// Plays the plan to its end.
inline GameRecord PlayGame(const GamePlan& plan) {
  Game game;
  EvaluationBatches batches;
  game.Start(plan);
  while (game.Gather(batches)) {
    batches.Evaluate(plan.setup.settings);
    game.Scatter(batches);
    batches.Clear();
  }
  return game.record();
}

// Gives out one plan per ticket and keeps the records, by ticket.
class ListHost : public GameHost {
 public:
  explicit ListHost(std::size_t games) : records(games) {}

  std::optional<GamePlan> NextGame(int slot) override {
    if (next_ == records.size()) return std::nullopt;
    GamePlan plan = PlanOf(slot, next_);
    plan.ticket = next_++;
    return plan;
  }
  void GameFinished(int /*slot*/, Game& game) override {
    records[game.record().ticket] = game.record();
  }
  [[nodiscard]] virtual GamePlan PlanOf(int slot, std::uint64_t ticket) = 0;

  std::vector<GameRecord> records;

 private:
  std::uint64_t next_ = 0;
};

// Games of one searching seat, rotating, against three SimpleUnbiased.
class SearchHost final : public ListHost {
 public:
  SearchHost(std::size_t games, const SearchSettings& settings)
      : ListHost(games), settings_(settings) {}

  GamePlan PlanOf(int slot, std::uint64_t ticket) override {
    std::array<Seat, kAgentCount> seats;
    seats.fill(kSimpleUnbiasedSeat);
    const AgentId seat = static_cast<AgentId>(ticket % kAgentCount);
    seats[seat] = kSearching;
    GamePlan plan;
    plan.setup = SetupOfSeats(seats, /*seed=*/1000 + ticket);
    plan.agents[seat] = {AgentOf(slot), {evaluator_, /*weights_version=*/0}};
    return plan;
  }

 private:
  Agent* AgentOf(int slot) {
    const auto index = static_cast<std::size_t>(slot);
    if (agents_.size() <= index) agents_.resize(index + 1);
    if (agents_[index] == nullptr) agents_[index] = std::make_unique<SearchAgent>(settings_);
    return agents_[index].get();
  }

  SearchSettings settings_;
  std::shared_ptr<Evaluator> evaluator_ = std::make_shared<UniformEvaluator>();
  std::vector<std::unique_ptr<Agent>> agents_;
};

}  // namespace powderkeg

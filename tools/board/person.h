#pragma once

// A person's seat in a game.

#include <optional>

#include "actors/play/search_agent.h"

namespace powderkeg {

// Moves as it is told, and has an adviser that sees what the person sees. One thread.
class Person final : public Agent {
 public:
  explicit Person(const SearchSettings& adviser) : adviser_(adviser) {}

  // The move; until then Gather waits for it.
  void Decide(Action action) { action_ = action; }

  // Searches, at the first call of a move. Throws as EvaluateBatch.
  [[nodiscard]] const SearchResult& Advice(Evaluator& evaluator);

  void StartGame(const GameSettings& settings, AgentId self, Rng rng) override;
  void Begin(const Observation& observation) override;
  bool Gather(EvaluationBatch& /*batch*/) override { return !action_; }
  void Scatter(const EvaluationBatch& /*batch*/) override {}
  [[nodiscard]] Action action() const override { return *action_; }

 private:
  SearchAgent adviser_;
  GameSettings settings_;
  std::optional<Action> action_;
};

}  // namespace powderkeg

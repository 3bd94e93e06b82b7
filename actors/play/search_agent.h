#pragma once

// An agent that searches.

#include <optional>

#include "actors/play/agent.h"
#include "actors/search/opponent_models.h"
#include "actors/search/search.h"
#include "common/config/search_settings.h"
#include "common/pommerman/belief.h"

namespace powderkeg {

// Observation -> Belief -> Search, the opponent models carried through the game. The tree is
// allocated with the first game and kept.
class SearchAgent final : public Agent {
 public:
  explicit SearchAgent(const SearchSettings& settings) : settings_(settings) {}

  void StartGame(const GameSettings& settings, AgentId self, Rng rng) override;
  void Begin(const Observation& observation) override;
  bool Gather(EvaluationBatch& batch) override;
  void Scatter(const EvaluationBatch& batch) override;
  [[nodiscard]] Action action() const override;
  [[nodiscard]] Message words() const override { return belief_->Report(action()); }
  [[nodiscard]] std::optional<Decision> decision() const override;
  [[nodiscard]] MoveStatistics move_statistics() const override;

  // Everything the search found for the last move.
  [[nodiscard]] const SearchResult& result() const;

 private:
  SearchSettings settings_;
  GameSettings game_;
  Rng rng_;
  std::optional<Belief> belief_;
  OpponentModels models_;
  std::optional<Search> search_;
  bool first_move_ = true;
  mutable std::optional<SearchResult> result_;  // of the last move, computed when asked for
};

// Counts as a Decision holds them: as they are, or scaled so that the largest is 65,535.
[[nodiscard]] std::array<std::uint16_t, kActionCount> RecordedVisits(
    const std::array<std::uint32_t, kActionCount>& visits);

}  // namespace powderkeg

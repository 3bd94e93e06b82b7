#pragma once

// Whoever plays a seat by looking at observations.

#include <array>
#include <cstdint>
#include <optional>

#include "common/base/rng.h"
#include "common/config/search_settings.h"
#include "common/model/evaluator.h"
#include "common/pommerman/observation.h"
#include "common/pommerman/types.h"
#include "common/record/game_record.h"

namespace powderkeg {

// What an agent tells of its last move beside the move, for reports.
struct MoveStatistics {
  bool late = false;  // it did not move in time: the environment plays kStop for it
  std::uint32_t simulations = 0;
  float mean_depth = 0;      // environment steps from the root to the leaves, mean over simulations
  int variation_length = 0;  // environment steps along the principal variation
  std::uint8_t predicted_agents = 0;  // bit i: prediction[i] is what agent i was expected to do
  JointAction prediction{};           // at the root, by the opponent models
  std::array<OpponentModel, kAgentCount> models{};  // of these agents
};

// A player in split phases, so that many games share one batch of evaluations: per move Begin, then
// Gather, evaluation and Scatter in turns until Gather returns false, then action(). Never blocks
// (but a ForeignAgent) and owns no thread. One thread; reused over games without allocating anew.
class Agent {
 public:
  virtual ~Agent() = default;

  // A new game as agent `self`; what was known of the last one is forgotten. `rng` serves the whole
  // game: equal games get equal moves.
  virtual void StartGame(const GameSettings& settings, AgentId self, Rng rng) = 0;

  // The next move is to be made on `observation`, in which `self` lives; every observation of the
  // game is given, in order. In radio games it holds the mate's words.
  virtual void Begin(const Observation& observation) = 0;

  // True: the agent goes on thinking and Scatter must follow; its questions, if there are any, were
  // added to the batch. False: the move is decided and nothing was added. The positions asked about
  // stay in place until Scatter.
  virtual bool Gather(EvaluationBatch& batch) = 0;

  // Takes the answers to the questions of the last Gather.
  virtual void Scatter(const EvaluationBatch& batch) = 0;

  // The move. Requires that Gather returned false since the last Begin, or that Scatter was the
  // last call (a clock ran out): then it is the best move found so far.
  [[nodiscard]] virtual Action action() const = 0;

  // What it tells its mate with the move, in radio games; (0, 0) is silence. Same requirement as
  // action().
  [[nodiscard]] virtual Message words() const { return {}; }

  // What the search found for the last move (without weights_version, which the agent cannot know);
  // nullopt if it was made without a search. Same requirement as action().
  [[nodiscard]] virtual std::optional<Decision> decision() const { return std::nullopt; }

  // The game is over, with the environment's reward: -1, 0 or +1. The dead are told too; nobody is
  // of a game that is not played to its end.
  virtual void EndGame(int /*reward*/) {}

  // Same requirement as action().
  [[nodiscard]] virtual MoveStatistics move_statistics() const { return {}; }
};

}  // namespace powderkeg

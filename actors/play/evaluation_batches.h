#pragma once

// Where the questions of many agents meet: one batch for each evaluator in use.

#include <cstdint>
#include <memory>
#include <vector>

#include "common/base/check.h"
#include "common/model/evaluator.h"
#include "common/pommerman/game_settings.h"

namespace powderkeg {

// Who answers an agent's questions.
struct Model {
  std::shared_ptr<Evaluator> evaluator;
  std::uint32_t weights_version = 0;  // of its weights; 0 for the uniform evaluator
};

// An evaluator answered with something that is not a number; says which evaluator and what.
class BadEvaluation : public Error {
 public:
  BadEvaluation(const Evaluator& evaluator, const Position& position, const Evaluation& evaluation);

  // Not to be used but for comparing.
  [[nodiscard]] const Evaluator* evaluator() const { return evaluator_; }
  // The position that was asked about, and whose view of it.
  [[nodiscard]] const State& state() const { return state_; }
  [[nodiscard]] AgentId viewer() const { return viewer_; }

 private:
  const Evaluator* evaluator_;
  State state_;
  AgentId viewer_;
};

// Lets the evaluator answer the batch. Throws BadEvaluation for the first answer that is not
// finite.
void EvaluateBatch(Evaluator& evaluator, const GameSettings& settings, EvaluationBatch& batch);

// One round of questions and answers: For and Add, Evaluate, For and read, Clear. Evaluators must
// outlive the round. One thread.
class EvaluationBatches {
 public:
  // The batch that `evaluator` answers; the reference holds until the next call.
  [[nodiscard]] EvaluationBatch& For(Evaluator& evaluator);

  // Lets every evaluator that was asked answer its batch. Blocks. Returns the number of batches
  // that were not empty. Throws as EvaluateBatch.
  int Evaluate(const GameSettings& settings);

  // Questions asked since Clear, to all evaluators together.
  [[nodiscard]] std::size_t size() const;

  // Starts the next round. Keeps the memory of batches that were used in this one and forgets
  // evaluators that nobody asked.
  void Clear();

 private:
  struct Group {
    Evaluator* evaluator;
    EvaluationBatch batch;
  };
  std::vector<Group> groups_;  // one, seldom two: old and new weights side by side
};

}  // namespace powderkeg

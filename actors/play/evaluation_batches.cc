#include "actors/play/evaluation_batches.h"

#include <utility>

namespace powderkeg {

EvaluationBatch& EvaluationBatches::For(Evaluator& evaluator) {
  for (Group& group : groups_) {
    if (group.evaluator == &evaluator) return group.batch;
  }
  groups_.push_back({&evaluator, {}});
  return groups_.back().batch;
}

int EvaluationBatches::Evaluate(const GameSettings& settings) {
  int batches = 0;
  for (Group& group : groups_) {
    if (group.batch.size() == 0) continue;
    group.evaluator->Evaluate(settings, group.batch.positions(), group.batch.AllocateEvaluations());
    ++batches;
  }
  return batches;
}

std::size_t EvaluationBatches::size() const {
  std::size_t questions = 0;
  for (const Group& group : groups_) questions += group.batch.size();
  return questions;
}

void EvaluationBatches::Clear() {
  std::erase_if(groups_, [](const Group& group) { return group.batch.size() == 0; });
  for (Group& group : groups_) group.batch.Clear();
}

}  // namespace powderkeg

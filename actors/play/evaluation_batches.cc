#include "actors/play/evaluation_batches.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>

namespace powderkeg {
namespace {

bool IsFinite(const Evaluation& evaluation) {
  return std::isfinite(evaluation.value) &&
         std::ranges::all_of(evaluation.policy, [](float p) { return std::isfinite(p); });
}

std::string ToText(const Evaluation& evaluation) {
  std::string text = "policy";
  for (const float probability : evaluation.policy) text += StrCat(" ", probability);
  return StrCat(text, ", value ", evaluation.value);
}

}  // namespace

void EvaluateBatch(Evaluator& evaluator, const GameSettings& settings, EvaluationBatch& batch) {
  const std::span<const Position> positions = batch.positions();
  const std::span<Evaluation> evaluations = batch.AllocateEvaluations();
  evaluator.Evaluate(settings, positions, evaluations);
  const auto bad = std::ranges::find_if_not(evaluations, IsFinite);
  if (bad == evaluations.end()) return;
  throw BadEvaluation(evaluator, positions[static_cast<std::size_t>(bad - evaluations.begin())],
                      *bad);
}

BadEvaluation::BadEvaluation(const Evaluator& evaluator, const Position& position,
                             const Evaluation& evaluation)
    : Error(StrCat("evaluator ", evaluator.name(), " answered ", ToText(evaluation), " for agent ",
                   position.viewer, " at step ", position.state->step,
                   ": expected finite numbers")),
      evaluator_(&evaluator),
      state_(*position.state),
      viewer_(position.viewer) {}

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
    EvaluateBatch(*group.evaluator, settings, group.batch);
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

#include "tools/board/person.h"

#include "actors/play/evaluation_batches.h"

namespace powderkeg {

const SearchResult& Person::Advice(Evaluator& evaluator) {
  EvaluationBatch batch;
  while (adviser_.Gather(batch)) {
    EvaluateBatch(evaluator, settings_, batch);
    adviser_.Scatter(batch);
    batch.Clear();
  }
  return adviser_.result();
}

void Person::StartGame(const GameSettings& settings, AgentId self, Rng rng) {
  settings_ = settings;
  adviser_.StartGame(settings, self, rng);
}

void Person::Begin(const Observation& observation) {
  action_.reset();
  adviser_.Begin(observation);
}

}  // namespace powderkeg

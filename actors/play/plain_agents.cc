#include "actors/play/plain_agents.h"

#include <bit>

#include "common/pommerman/step.h"

namespace powderkeg {

void RawNetworkAgent::StartGame(const GameSettings& settings, AgentId /*self*/, Rng /*rng*/) {
  belief_.emplace(settings);
  decided_ = true;
}

void RawNetworkAgent::Begin(const Observation& observation) {
  belief_->Observe(observation);
  const ActionSet legal = LegalActions(belief_->state(), belief_->self());
  decided_ = std::has_single_bit(legal);
  if (decided_) action_ = static_cast<Action>(std::countr_zero(legal));
}

bool RawNetworkAgent::Gather(EvaluationBatch& batch) {
  if (decided_) return false;
  slot_ = batch.Add({&belief_->state(), belief_->self(), belief_->visible()});
  return true;
}

void RawNetworkAgent::Scatter(const EvaluationBatch& batch) {
  const ActionSet legal = LegalActions(belief_->state(), belief_->self());
  action_ = BestAction(batch.evaluation(slot_).policy, legal);
  decided_ = true;
}

void RuleBasedAgent::StartGame(const GameSettings& settings, AgentId /*self*/, Rng rng) {
  settings_ = settings;
  belief_.emplace(settings);
  rng_ = rng;
  traits_ = PolicyTraits::Draw(rng_);
  memory_ = PolicyMemory();
}

void RuleBasedAgent::Begin(const Observation& observation) {
  belief_->Observe(observation);
  const PolicyView view{belief_->state(), settings_, belief_->self(), belief_->visible()};
  action_ = Decide(kind_, view, traits_, memory_, rng_);
}

void PessimistAgent::StartGame(const GameSettings& settings, AgentId /*self*/, Rng rng) {
  settings_ = settings;
  belief_.emplace(settings);
  rng_ = rng;
  cell_ = kNoCell;
}

void PessimistAgent::Begin(const Observation& observation) {
  belief_->Observe(observation);
  std::optional<Action> bounced;
  if (cell_ == observation.position && IsMove(action_)) bounced = action_;
  action_ = pessimist_.Choose(settings_, belief_->state(), belief_->self(), belief_->visible(),
                              rng_, bounced);
  cell_ = observation.position;
}

}  // namespace powderkeg

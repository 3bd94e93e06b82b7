#include "actors/play/search_agent.h"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace powderkeg {
namespace {

// Purposes of the generators split from a game's.
constexpr std::uint64_t kModelsPurpose = 0;
constexpr std::uint64_t kFirstMovePurpose = 1;  // + step

}  // namespace

void SearchAgent::StartGame(const GameSettings& settings, AgentId self, Rng rng) {
  if (!search_ || !(settings == game_)) search_.emplace(settings_, settings);
  game_ = settings;
  rng_ = rng;
  belief_.emplace(settings);
  models_.StartGame(settings_, settings, self, rng.Split(kModelsPurpose));
  first_move_ = true;
  result_.reset();
}

void SearchAgent::Begin(const Observation& observation) {
  const Belief before = *belief_;
  belief_->Observe(observation);
  if (!first_move_) {
    models_.ObserveStep({before.state(), before.visible()}, {belief_->state(), belief_->visible()},
                        search_->foretold());
  }
  first_move_ = false;
  search_->Start(belief_->state(), models_, rng_.Split(kFirstMovePurpose + observation.step));
  result_.reset();
}

bool SearchAgent::Gather(EvaluationBatch& batch) {
  result_.reset();
  return search_->Gather(batch);
}

void SearchAgent::Scatter(const EvaluationBatch& batch) { search_->Scatter(batch); }

const SearchResult& SearchAgent::result() const {
  if (!result_) result_ = search_->Result();
  return *result_;
}

Action SearchAgent::action() const { return result().best; }

std::optional<Decision> SearchAgent::decision() const {
  const bool visited = result().visits != std::array<std::uint32_t, kActionCount>{};
  if (!result().searched || !visited) return std::nullopt;
  Decision decision;
  decision.step = belief_->state().step;
  if (result().full_search) decision.visits = RecordedVisits(result().target);
  decision.value = result().value;
  return decision;
}

MoveStatistics SearchAgent::move_statistics() const {
  MoveStatistics statistics;
  if (!result().searched) return statistics;
  statistics.simulations = static_cast<std::uint32_t>(result().simulations);
  statistics.mean_depth = static_cast<float>(result().mean_depth);
  statistics.variation_length = result().variation_length;
  statistics.prediction = result().expected_actions;
  statistics.predicted_agents = result().expected_agents;
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    if (agent == models_.self()) continue;
    statistics.models[static_cast<std::size_t>(agent)] = ModelOf(models_.Of(agent));
  }
  return statistics;
}

std::array<std::uint16_t, kActionCount> RecordedVisits(
    const std::array<std::uint32_t, kActionCount>& visits) {
  constexpr std::uint64_t kLimit = std::numeric_limits<std::uint16_t>::max();
  const std::uint64_t largest = std::max<std::uint64_t>(*std::ranges::max_element(visits), kLimit);
  std::array<std::uint16_t, kActionCount> recorded{};
  for (std::size_t action = 0; action < visits.size(); ++action) {
    recorded[action] = static_cast<std::uint16_t>(visits[action] * kLimit / largest);
  }
  return recorded;
}

}  // namespace powderkeg

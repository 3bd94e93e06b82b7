#include "actors/play/game_loop.h"

#include <algorithm>
#include <cstddef>

#include "common/base/check.h"

namespace powderkeg {

LoopMetrics& LoopMetrics::operator+=(const LoopMetrics& other) {
  games += other.games;
  steps += other.steps;
  decisions += other.decisions;
  simulations += other.simulations;
  evaluations += other.evaluations;
  batches += other.batches;
  return *this;
}

double LoopMetrics::mean_batch() const {
  return batches == 0 ? 0.0 : static_cast<double>(evaluations) / static_cast<double>(batches);
}

GameLoop::GameLoop(GameHost& host, const GameSettings& settings, int games_in_flight)
    : host_(host), settings_(settings), slots_(static_cast<std::size_t>(games_in_flight)) {
  CHECK(games_in_flight > 0, games_in_flight);
}

bool GameLoop::RunRound() {
  batches_.Clear();
  bool playing = false;
  for (int slot = 0; slot < static_cast<int>(slots_.size()); ++slot) {
    if (!slots_[slot].playing && !StartGame(slot)) continue;
    playing = true;
    if (!slots_[slot].game.Gather(batches_)) FinishGame(slot);
  }
  metrics_.evaluations += batches_.size();
  metrics_.batches += static_cast<std::uint64_t>(batches_.Evaluate(settings_));
  for (Slot& slot : slots_) {
    if (slot.playing) slot.game.Scatter(batches_);
  }
  return playing;
}

void GameLoop::SetModel(const Model& model) {
  for (Slot& slot : slots_) {
    if (slot.playing) slot.game.SetModel(model);
  }
}

const Game* GameLoop::running_game(int slot) const {
  return slots_[slot].playing ? &slots_[slot].game : nullptr;
}

int GameLoop::games_running() const {
  return static_cast<int>(std::ranges::count_if(slots_, &Slot::playing));
}

bool GameLoop::StartGame(int slot) {
  const std::optional<GamePlan> plan = host_.NextGame(slot);
  if (!plan) return false;
  CHECK(plan->setup.settings == settings_, "ticket ", plan->ticket);
  slots_[slot].game.Start(*plan);
  slots_[slot].playing = true;
  return true;
}

void GameLoop::FinishGame(int slot) {
  Game& game = slots_[slot].game;
  slots_[slot].playing = false;
  ++metrics_.games;
  metrics_.steps += game.record().actions.size();
  metrics_.decisions += DecisionCount(game.record());
  for (AgentId seat = 0; seat < kAgentCount; ++seat) {
    const bool demonstrates = game.plan().setup.seats[seat].teaches == Teaches::kMoves;
    if (demonstrates) metrics_.decisions += game.statistics(seat).moves;
    metrics_.simulations += game.statistics(seat).simulations;
  }
  host_.GameFinished(slot, game);
}

}  // namespace powderkeg

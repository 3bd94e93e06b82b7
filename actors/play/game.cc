#include "actors/play/game.h"

#include <cstddef>
#include <optional>

#include "common/base/check.h"
#include "common/pommerman/observation.h"

namespace powderkeg {

void Game::Start(const GamePlan& plan) {
  plan_ = plan;
  const GameSetup& setup = plan_.setup;
  state_ = GenerateStart(setup.settings, setup.start, BoardRng(setup));
  record_ = GameRecord();
  record_.ticket = plan_.ticket;
  record_.setup = setup;
  statistics_ = {};
  watcher_ = {};
  recent_cells_ = {};
  for (AgentId seat = 0; seat < kAgentCount; ++seat) {
    if (setup.seats[seat].searches) {
      SeatAgent(seat);
    } else {
      rule_based_[seat] = RuleBasedSeat(setup, seat);
    }
  }
  over_ = false;
  BeginStep();
}

void Game::SeatAgent(AgentId seat) {
  const auto& [agent, model, takes_new_weights] = plan_.agents[seat];
  CHECK(agent != nullptr && model.evaluator != nullptr, "seat ", seat);
  agent->StartGame(plan_.setup.settings, seat, SearchRng(plan_.setup, seat));
  record_.tracks[seat].weights_version = model.weights_version;
  if (record_.evaluator.empty()) record_.evaluator = model.evaluator->name();
}

bool Game::Gather(EvaluationBatches& batches) {
  while (!over_) {
    if (GatherMoves(batches)) return true;
    PlayStep();
  }
  return false;
}

void Game::Scatter(EvaluationBatches& batches) {
  for (AgentId seat = 0; seat < kAgentCount; ++seat) {
    if (phases_[seat] != Phase::kAsking) continue;
    const SeatedAgent& seated = plan_.agents[seat];
    seated.agent->Scatter(batches.For(*seated.model.evaluator));
    phases_[seat] = Phase::kThinking;
  }
}

void Game::SetModel(const Model& model) {
  for (SeatedAgent& seated : plan_.agents) {
    if (seated.takes_new_weights) seated.model = model;
  }
}

// Everybody looks at the position at once; rule-based seats decide at once too.
void Game::BeginStep() {
  for (AgentId seat = 0; seat < kAgentCount; ++seat) {
    actions_[seat] = Action::kStop;
    words_[seat] = {};
    phases_[seat] = Phase::kDecided;
    if (state_.agents[seat].alive) BeginMove(seat);
  }
}

void Game::BeginMove(AgentId seat) {
  if (plan_.setup.seats[seat].searches) {
    plan_.agents[seat].agent->Begin(Observe(plan_.setup.settings, state_, seat));
    phases_[seat] = Phase::kThinking;
  } else {
    actions_[seat] = rule_based_[seat].Decide(plan_.setup.settings, state_);
  }
}

bool Game::GatherMoves(EvaluationBatches& batches) {
  bool asking = false;
  for (AgentId seat = 0; seat < kAgentCount; ++seat) {
    if (phases_[seat] != Phase::kThinking) continue;
    const SeatedAgent& seated = plan_.agents[seat];
    if (seated.agent->Gather(batches.For(*seated.model.evaluator))) {
      phases_[seat] = Phase::kAsking;
      asking = true;
    } else {
      FinishMove(seat);
    }
  }
  return asking;
}

void Game::FinishMove(AgentId seat) {
  phases_[seat] = Phase::kDecided;
  const Agent& agent = *plan_.agents[seat].agent;
  actions_[seat] = agent.action();
  if (plan_.setup.settings.mode == Mode::kTeamRadio) words_[seat] = agent.words();
}

void Game::PlayStep() {
  for (AgentId seat = 0; seat < kAgentCount; ++seat) {
    if (state_.agents[seat].alive) {
      RecordMove(seat);
    } else {
      actions_[seat] = Action::kStop;  // it may have decided just before a collapse killed it
    }
  }
  record_.actions.push_back(actions_);
  const GameSettings& settings = plan_.setup.settings;
  const State before = state_;
  Step(settings, actions_, words_, state_);
  CountEvents(watcher_.Watch(settings, before, actions_, state_), settings.mode, statistics_);
  record_.outcome = OutcomeOf(settings, state_);
  over_ = record_.outcome.done || EndsEarly(plan_.setup, state_);
  if (over_) return EndGame();
  BeginStep();
  Collapse(settings, state_);
}

void Game::EndGame() {
  for (AgentId seat = 0; seat < kAgentCount; ++seat) {
    Agent* const agent = plan_.agents[seat].agent;
    if (agent != nullptr) agent->EndGame(record_.outcome.rewards[seat]);
  }
}

void Game::RecordMove(AgentId seat) {
  SeatStatistics& statistics = statistics_[seat];
  ++statistics.moves;
  ++statistics.actions[static_cast<std::size_t>(actions_[seat])];
  CountCell(state_.agents[seat].cell, plan_.setup.settings.board_size, recent_cells_[seat],
            statistics);
  if (!plan_.setup.seats[seat].searches) return;
  if (plan_.setup.seats[seat].teaches == Teaches::kSearch) RecordDecision(seat);
  const MoveStatistics move = plan_.agents[seat].agent->move_statistics();
  statistics.late_moves += move.late ? 1 : 0;
  if (move.simulations == 0) return;
  ++statistics.searches;
  statistics.simulations += move.simulations;
  statistics.depth_sum += move.mean_depth;
  statistics.variation_sum += static_cast<std::uint64_t>(move.variation_length);
  CountPredictions(move, statistics);
}

void Game::RecordDecision(AgentId seat) {
  std::optional<Decision> decision = plan_.agents[seat].agent->decision();
  if (!decision) return;
  decision->step = state_.step;
  decision->weights_version = plan_.agents[seat].model.weights_version;
  record_.tracks[seat].decisions.push_back(*decision);
}

void Game::CountPredictions(const MoveStatistics& move, SeatStatistics& statistics) const {
  for (AgentId seat = 0; seat < kAgentCount; ++seat) {
    if (!Has(move.predicted_agents, seat)) continue;
    ++statistics.predictions;
    ++statistics.taken_for[static_cast<std::size_t>(move.models[seat])];
    if (move.prediction[seat] == actions_[seat]) ++statistics.predictions_right;
  }
}

}  // namespace powderkeg

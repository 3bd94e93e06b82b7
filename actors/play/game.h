#pragma once

// One game as a state machine that never blocks.

#include <array>
#include <cstdint>

#include "actors/play/agent.h"
#include "actors/play/evaluation_batches.h"
#include "actors/play/seat_statistics.h"
#include "actors/play/step_events.h"
#include "common/record/game_record.h"
#include "common/record/rule_based_seat.h"

namespace powderkeg {

// Who moves for a seat that searches: an agent of the caller, used by this game alone, and whoever
// answers it.
struct SeatedAgent {
  Agent* agent = nullptr;
  Model model;
  bool takes_new_weights = false;  // SetModel changes its model
};

// A game to be played.
struct GamePlan {
  std::uint64_t ticket = 0;
  GameSetup setup;
  std::array<SeatedAgent, kAgentCount> agents;  // there exactly where setup.seats[i].searches
};

// Plays GamePlans, one after the other, each until the environment is done or it EndsEarly.
// Rule-based seats decide on the true position (their rules look at nothing hidden) exactly as
// Verify re-runs them; the others see observations only. One thread; the memory of the last game is
// reused.
class Game {
 public:
  void Start(const GamePlan& plan);

  // Plays on until an agent needs answers (true) or the game is over (false). Requires that Scatter
  // followed the last Gather that returned true.
  bool Gather(EvaluationBatches& batches);
  // Hands out the answers to the questions of the last Gather.
  void Scatter(EvaluationBatches& batches);

  // Lets `model` answer the agents that take new weights from now on. Not between Gather and
  // Scatter.
  void SetModel(const Model& model);

  [[nodiscard]] const GamePlan& plan() const { return plan_; }
  // The position that is decided on, or at the end of the game.
  [[nodiscard]] const State& state() const { return state_; }
  // Complete once Gather returned false.
  [[nodiscard]] const GameRecord& record() const { return record_; }
  [[nodiscard]] const SeatStatistics& statistics(AgentId seat) const { return statistics_[seat]; }

 private:
  enum class Phase : std::uint8_t {
    kDecided,   // the action stands (also of the dead)
    kThinking,  // the agent may ask
    kAsking,    // the agent waits for answers
  };

  void SeatAgent(AgentId seat);
  void BeginStep();
  void BeginMove(AgentId seat);
  [[nodiscard]] bool GatherMoves(EvaluationBatches& batches);
  void FinishMove(AgentId seat);
  void PlayStep();
  void EndGame();
  void RecordMove(AgentId seat);
  void RecordDecision(AgentId seat);
  void CountPredictions(const MoveStatistics& move, SeatStatistics& statistics) const;

  GamePlan plan_;
  State state_;
  std::array<RuleBasedSeat, kAgentCount> rule_based_;
  std::array<Phase, kAgentCount> phases_{};
  JointAction actions_{};
  std::array<Message, kAgentCount> words_{};  // radio: sent with the actions
  bool over_ = true;
  GameRecord record_;
  GameStatistics statistics_{};
  StepWatcher watcher_;
  std::array<RecentCells, kAgentCount> recent_cells_;
};

}  // namespace powderkeg

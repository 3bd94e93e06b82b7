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
struct Player {
  Agent* agent = nullptr;
  Model model;
};

// A game to be played.
struct GamePlan {
  std::uint64_t ticket = 0;
  GameSetup setup;
  std::array<Player, kAgentCount> players;  // an agent exactly where setup.seats[i].searches
  enum class End : std::uint8_t {
    kOfficial,         // play on until the environment is done
    kLastSearchDeath,  // or until no searching seat lives
  };
  End end = End::kOfficial;
};

// Plays GamePlans, one after the other. Rule-based seats decide on the true position (their rules
// look at nothing hidden) exactly as Verify re-runs them; the others see observations only. One
// thread; the memory of the last game is reused.
class Game {
 public:
  void Start(const GamePlan& plan);

  // Plays on until an agent needs answers (true) or the game is over (false). Requires that Scatter
  // followed the last Gather that returned true.
  bool Gather(EvaluationBatches& batches);
  // Hands out the answers to the questions of the last Gather.
  void Scatter(EvaluationBatches& batches);

  // Lets `model` answer every agent from now on (weights swapped at once). Not between Gather and
  // Scatter.
  void SetModel(const Model& model);

  [[nodiscard]] const GamePlan& plan() const { return plan_; }
  // The position that is decided on, or at the end of the game.
  [[nodiscard]] const State& state() const { return state_; }
  // Complete once Gather returned false. `evaluator` and `weights_version` are those of the first
  // searching seat at the start of the game.
  [[nodiscard]] const GameRecord& record() const { return record_; }
  // Moves the record out of a finished game.
  [[nodiscard]] GameRecord TakeRecord() { return std::move(record_); }
  [[nodiscard]] const SeatStatistics& statistics(AgentId seat) const { return statistics_[seat]; }

 private:
  enum class Phase : std::uint8_t {
    kDecided,   // the action stands (also of the dead)
    kThinking,  // the agent may ask
    kAsking,    // the agent waits for answers
  };

  void BeginStep();
  void BeginMove(AgentId seat);
  [[nodiscard]] bool GatherMoves(EvaluationBatches& batches);
  void FinishMove(AgentId seat);
  void PlayStep();
  void RecordMove(AgentId seat);
  void CountPredictions(const MoveStatistics& move, SeatStatistics& statistics) const;
  [[nodiscard]] bool EndsByDeath() const;

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

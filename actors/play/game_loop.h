#pragma once

// Many games side by side on one thread, their questions answered in common batches.

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "actors/play/evaluation_batches.h"
#include "actors/play/game.h"

namespace powderkeg {

// Counters since the start of a loop.
struct LoopMetrics {
  std::uint64_t games = 0;        // finished
  std::uint64_t steps = 0;        // of finished games
  std::uint64_t decisions = 0;    // recorded in finished games
  std::uint64_t simulations = 0;  // of finished games
  std::uint64_t evaluations = 0;  // positions answered
  std::uint64_t batches = 0;

  LoopMetrics& operator+=(const LoopMetrics& other);
  // Positions per batch; 0 before the first batch.
  [[nodiscard]] double mean_batch() const;
};

// Whom a loop plays for. Called on the loop's thread.
class GameHost {
 public:
  virtual ~GameHost() = default;

  // The next game of the slot (0 to games in flight - 1), or nullopt for none now: the slot pauses
  // and asks again in the next round. Agents of a slot's plan may be those of its last game.
  [[nodiscard]] virtual std::optional<GamePlan> NextGame(int slot) = 0;

  // A game is over. `game` holds its plan, record and statistics; the record may be taken out.
  virtual void GameFinished(int slot, Game& game) = 0;
};

// One thread. The host must outlive the loop. All games have the same GameSettings.
class GameLoop {
 public:
  GameLoop(GameHost& host, const GameSettings& settings, int games_in_flight);

  // One round: asks the host for games where slots are free, gathers from all games, evaluates,
  // scatters to all. False if no game is in flight: the host gave none.
  bool RunRound();

  // Lets `model` answer in every game that is running (later games bring their own).
  void SetModel(const Model& model);

  // The game that the slot is playing, or nullptr.
  [[nodiscard]] const Game* running_game(int slot) const;
  // Games being played now.
  [[nodiscard]] int games_running() const;
  [[nodiscard]] const LoopMetrics& metrics() const { return metrics_; }

 private:
  struct Slot {
    bool playing = false;
    Game game;
  };

  bool StartGame(int slot);
  void FinishGame(int slot);

  GameHost& host_;
  GameSettings settings_;
  std::vector<Slot> slots_;
  EvaluationBatches batches_;
  LoopMetrics metrics_;
};

}  // namespace powderkeg

#pragma once

// Many games of one kind, stepped together: what the Python environments are made of.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/rng.h"
#include "common/record/game_record.h"
#include "common/record/rule_based_seat.h"

namespace powderkeg {

struct GameBatchSettings {
  GameSettings game;
  // Who moves a seat; nullopt: the caller.
  std::array<std::optional<PolicyKind>, kAgentCount> policies;
  // Otherwise a game ends as soon as none of the caller's agents (and their mates) lives.
  bool to_the_end = true;
  // A game that is over begins anew in the same call; otherwise it stays as it is.
  bool restart = true;
};

// What a step leads to, one entry per game (of the rewards four). All of the game that was stepped,
// even if another has begun since.
struct StepResults {
  std::span<float> rewards;  // official, of all agents; 0 of a game that was over before
  std::span<bool> done;
  std::span<std::uint8_t> winners;  // bit i: agent i; 0 of a tie and while nobody has won
  std::span<std::uint16_t> steps;   // played
};

// Between steps the games stand as the official environment shows them: a board that collapses does
// so at the beginning of the next step. One thread.
class GameBatch {
 public:
  // Equal arguments give equal games on every machine; game i depends on the seed and i alone.
  GameBatch(const GameBatchSettings& settings, std::size_t size, std::uint64_t seed);

  // All games anew: those of this seed, or the next of the present one.
  void Reset(std::optional<std::uint64_t> seed);

  // `actions` and `messages` hold what every agent does and says, row by row; the seats of policies
  // and the dead are ignored. Requires as many rows as games; messages may be empty: silence.
  void Step(std::span<const JointAction> actions,
            std::span<const std::array<Message, kAgentCount>> messages, const StepResults& results);

  [[nodiscard]] std::size_t size() const { return games_.size(); }
  [[nodiscard]] const GameBatchSettings& settings() const { return settings_; }
  [[nodiscard]] const State& state(std::size_t game) const { return games_[game].state; }
  // What everybody did in the last step of the game; all kStop before the first.
  [[nodiscard]] const JointAction& actions(std::size_t game) const { return games_[game].actions; }

 private:
  struct Game {
    Rng seeds;  // of its further games
    State state;
    std::array<RuleBasedSeat, kAgentCount> seats;  // of policies
    JointAction actions{};
    bool over = false;
  };
  void Begin(Game& game);
  // Returns the outcome, done also where it ends early.
  Outcome StepGame(Game& game, const JointAction& actions,
                   const std::array<Message, kAgentCount>& messages);

  GameBatchSettings settings_;
  GameSetup setup_;  // of every game, but for its seed
  std::vector<Game> games_;
};

}  // namespace powderkeg

#pragma once

// A game as the page is told of it.

#include <array>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "actors/play/step_events.h"
#include "tools/viewer/stored_game.h"

namespace powderkeg {

// Plays a game by the rules, step by step, and tells it. A value; one thread.
class GameStory {
 public:
  GameStory(const GameSettings& settings, const State& start);

  void Play(const JointAction& actions, const std::array<Message, kAgentCount>& messages = {});

  // What happened since the last call; the first one tells of the start too.
  //   frames: [[board, bombs, agents, words], ...], one a position:
  //     board   121 characters: . passage, # rigid, + wood, 1 to 3 flame and the steps it burns on,
  //             b extra bomb, r range, k kick
  //     bombs   per bomb five numbers: cell, life, blast strength, owner, direction
  //     agents  per agent five numbers: cell, ammo, blast strength, kick, alive
  //     words   per agent two numbers, in radio games
  //   moves:  per step one character an agent: its action, or - where it was dead
  //   deaths: [[step, agent, set of killers], ...]: in the position after so many steps it is dead;
  //           nobody's flames where the collapsing board killed it
  [[nodiscard]] nlohmann::json TakeNews();

  [[nodiscard]] const State& state() const { return state_; }

 private:
  void TellFrame();
  void TellDeaths(const State& before, const StepEvents& events);

  GameSettings settings_;
  State state_;
  int steps_ = 0;
  StepWatcher watcher_;
  nlohmann::json news_;
};

// What does not change: name, mode, size of the board, radius of view (0: all), players, and the
// number of seats.
[[nodiscard]] nlohmann::json HeadJson(const std::string& name, const GameSettings& settings,
                                      const std::array<std::string, kAgentCount>& players);

// What searches found, each as [step, six visit counts, value].
[[nodiscard]] nlohmann::json DecisionsJson(std::span<const Decision> decisions);

// Head, story, searches by agent, and the end: result and winners.
[[nodiscard]] std::string GameJson(const StoredGame& stored);

// "incomplete", "win" or "tie".
[[nodiscard]] const char* ResultName(Result result);

}  // namespace powderkeg

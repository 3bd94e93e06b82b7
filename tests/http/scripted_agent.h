#pragma once

// An agent that asks as often as it is told to and writes down what happens to it.

#include <vector>

#include "actors/play/agent.h"

namespace powderkeg {

// What a ScriptedAgent saw; outlives it.
struct AgentDiary {
  std::vector<AgentId> games;  // the agent's id in every game started
  std::vector<int> steps;      // of all observations
  std::vector<Cell> mates;     // where it was told that the mate is
  int rounds = 0;              // answered questions
  GameSettings settings;       // of the last game
};

// Asks `rounds` times about a start position before each move, then stops.
class ScriptedAgent final : public Agent {
 public:
  ScriptedAgent(AgentDiary& diary, int rounds) : diary_(diary), rounds_(rounds) {}

  void StartGame(const GameSettings& settings, AgentId self, Rng /*rng*/) override {
    diary_.games.push_back(self);
    diary_.settings = settings;
  }
  void HearMate(Cell cell) override { diary_.mates.push_back(cell); }
  void Begin(const Observation& observation) override {
    diary_.steps.push_back(observation.step);
    left_ = rounds_;
  }
  bool Gather(EvaluationBatch& batch) override {
    if (left_ == 0) return false;
    --left_;
    batch.Add({.state = &state_, .viewer = 0});
    return true;
  }
  void Scatter(const EvaluationBatch& batch) override {
    diary_.rounds += static_cast<int>(batch.size());
  }
  [[nodiscard]] Action action() const override { return Action::kBomb; }

 private:
  AgentDiary& diary_;
  int rounds_;
  int left_ = 0;
  State state_{};
};

}  // namespace powderkeg

#pragma once

// An agent that asks as often as it is told to and writes down what happens to it.

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "actors/play/agent.h"

namespace powderkeg {

// What a ScriptedAgent saw; outlives it.
struct AgentDiary {
  std::vector<AgentId> games;  // the agent's id in every game started
  std::vector<int> steps;      // of all observations
  std::vector<Message> heard;  // the mate's words in all observations
  int rounds = 0;              // answered questions
  GameSettings settings;       // of the last game
};

// Asks `rounds` times about a start position before each move, then stops. After n rounds of a move
// actions[n] is the best, or the last one. Calls that an agent does not expect fail the test.
class ScriptedAgent final : public Agent {
 public:
  ScriptedAgent(AgentDiary& diary, int rounds, std::vector<Action> actions = {Action::kBomb})
      : diary_(diary), rounds_(rounds), actions_(std::move(actions)) {}

  void StartGame(const GameSettings& settings, AgentId self, Rng /*rng*/) override {
    diary_.games.push_back(self);
    diary_.settings = settings;
  }
  void Begin(const Observation& observation) override {
    EXPECT_FALSE(asks_) << "Begin between Gather and Scatter";
    diary_.steps.push_back(observation.step);
    diary_.heard.push_back(observation.message);
    made_ = 0;
    decided_ = false;
  }
  bool Gather(EvaluationBatch& batch) override {
    EXPECT_FALSE(asks_) << "Gather before Scatter";
    decided_ = made_ == rounds_;
    if (decided_) return false;
    asks_ = true;
    batch.Add({.state = &state_, .viewer = 0});
    return true;
  }
  void Scatter(const EvaluationBatch& batch) override {
    EXPECT_EQ(batch.size(), 1U);
    asks_ = false;
    ++made_;
    ++diary_.rounds;
  }
  [[nodiscard]] Action action() const override {
    EXPECT_TRUE(decided_ || (made_ > 0 && !asks_)) << "action() before there is one";
    return actions_[std::min(static_cast<std::size_t>(made_), actions_.size() - 1)];
  }
  [[nodiscard]] Message words() const override {
    return {static_cast<std::uint8_t>(1 + static_cast<int>(action())), 7};
  }

 private:
  AgentDiary& diary_;
  int rounds_;
  std::vector<Action> actions_;
  int made_ = 0;          // rounds of this move
  bool asks_ = false;     // between Gather and Scatter
  bool decided_ = false;  // Gather returned false
  State state_{};
};

}  // namespace powderkeg

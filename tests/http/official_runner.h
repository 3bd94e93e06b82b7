#pragma once

// A client that behaves as the official runner and plays by our own rules.

#include <array>
#include <string>
#include <vector>

#include "actors/runner/official_client.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/state.h"

namespace powderkeg {

struct GameReport {
  int steps = 0;
  // The first request that was not answered as the runner needs it; empty: all were.
  std::string failure;
};

// The environment with four HTTP agents: pings and initialises them once, asks the living ones in
// id order, ends the episode for all. A new connection for each request.
class OfficialRunner {
 public:
  OfficialRunner(const GameSettings& settings, const std::array<int, kAgentCount>& ports);

  // From now on an action of this agent that LegalActions excludes is a failure.
  void RequireLegal(AgentId agent) { legal_[agent] = true; }

  // Plays to the end or for max_steps.
  [[nodiscard]] GameReport PlayGame(std::uint64_t seed, int max_steps);

  // Closes the environment: /shutdown.
  void Close();

 private:
  [[nodiscard]] GameReport Play(std::uint64_t seed, int max_steps);
  void Start();
  // The action and, in radio games, the message of an agent; kStop after a failure.
  Action Ask(AgentId agent, const State& state, Message& words);
  void Expect200(AgentId agent, const char* path, int status);
  // Keeps the first failure.
  void Note(AgentId agent, const std::string& failure);

  GameSettings settings_;
  std::vector<OfficialClient> clients_;  // by agent
  std::array<bool, kAgentCount> legal_{};
  bool started_ = false;
  std::string failure_;
};

}  // namespace powderkeg

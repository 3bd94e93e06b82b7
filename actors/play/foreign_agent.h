#pragma once

// Anybody's agent, behind HTTP.

#include "actors/play/agent.h"
#include "actors/runner/official_client.h"

namespace powderkeg {

// An agent that speaks the official protocol, for which this program is the official runner. Unlike
// other agents it blocks (OfficialClient says for how long): StartGame, Begin, which waits for the
// move, and EndGame; and these throw Error. The server has one memory: one agent of its address
// plays at a time.
class ForeignAgent final : public Agent {
 public:
  explicit ForeignAgent(const ForeignSettings& settings) : client_(settings) {}
  ~ForeignAgent() override;

  // A server that outlives a game meets a new agent with each: seats change.
  void StartGame(const GameSettings& settings, AgentId self, Rng rng) override;
  void Begin(const Observation& observation) override;
  bool Gather(EvaluationBatch& /*batch*/) override { return false; }
  void Scatter(const EvaluationBatch& /*batch*/) override {}
  void EndGame(int reward) override { client_.EndEpisode(reward); }
  [[nodiscard]] Action action() const override { return move_.action; }
  [[nodiscard]] Message words() const override { return move_.words; }
  [[nodiscard]] MoveStatistics move_statistics() const override { return {.late = move_.late}; }

 private:
  OfficialClient client_;
  bool met_ = false;
  GameSettings settings_;
  RunnerMove move_;
};

}  // namespace powderkeg

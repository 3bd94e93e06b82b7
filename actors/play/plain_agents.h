#pragma once

// Agents without a search: a network alone, and rule-based policies fed by observations.

#include <cstddef>
#include <optional>

#include "actors/pessimist/pessimist.h"
#include "actors/play/agent.h"
#include "common/policies/policy.h"
#include "common/pommerman/belief.h"

namespace powderkeg {

// Plays the legal action that the network's policy likes best (ties: the lowest); one evaluation a
// move, none where a single action is legal.
class RawNetworkAgent final : public Agent {
 public:
  void StartGame(const GameSettings& settings, AgentId self, Rng rng) override;
  void Begin(const Observation& observation) override;
  bool Gather(EvaluationBatch& batch) override;
  void Scatter(const EvaluationBatch& batch) override;
  [[nodiscard]] Action action() const override { return action_; }
  [[nodiscard]] Message words() const override { return belief_->Report(action_); }

 private:
  std::optional<Belief> belief_;
  bool decided_ = true;
  std::size_t slot_ = 0;
  Action action_ = Action::kStop;
};

// A rule-based policy as an agent, silent as the official one, for where there are only
// observations (the official runner). A Game has rule-based seats of its own, which cost less and
// are verifiable.
class RuleBasedAgent final : public Agent {
 public:
  explicit RuleBasedAgent(PolicyKind kind) : kind_(kind) {}

  // `rng` is used as the seat's generator of a recorded game: with SeatRng(setup, seat), and the
  // whole board in view, the agent moves as that rule-based seat.
  void StartGame(const GameSettings& settings, AgentId self, Rng rng) override;
  void Begin(const Observation& observation) override;
  bool Gather(EvaluationBatch& /*batch*/) override { return false; }
  void Scatter(const EvaluationBatch& /*batch*/) override {}
  [[nodiscard]] Action action() const override { return action_; }

 private:
  PolicyKind kind_;
  GameSettings settings_;
  std::optional<Belief> belief_;
  PolicyTraits traits_;
  PolicyMemory memory_;
  Rng rng_;
  Action action_ = Action::kStop;
};

// The pessimist fed by observations; says where it is as all agents that think.
class PessimistAgent final : public Agent {
 public:
  explicit PessimistAgent(const PessimistSettings& settings) : pessimist_(settings) {}

  void StartGame(const GameSettings& settings, AgentId self, Rng rng) override;
  void Begin(const Observation& observation) override;
  bool Gather(EvaluationBatch& /*batch*/) override { return false; }
  void Scatter(const EvaluationBatch& /*batch*/) override {}
  [[nodiscard]] Action action() const override { return action_; }
  [[nodiscard]] Message words() const override { return belief_->Report(action_); }

 private:
  Pessimist pessimist_;
  GameSettings settings_;
  std::optional<Belief> belief_;
  Rng rng_;
  Cell cell_ = kNoCell;  // when it decided last
  Action action_ = Action::kStop;
};

}  // namespace powderkeg

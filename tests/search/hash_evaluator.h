#pragma once

// An evaluator for tests whose answers are arbitrary, but always the same.

#include <gtest/gtest.h>

#include <cstdint>
#include <span>
#include <string>

#include "common/base/rng.h"
#include "common/model/evaluator.h"

namespace powderkeg {

// Policies and values that differ from position to position and from viewer to viewer, and what the
// others do; checks that the viewers live.
class HashEvaluator final : public Evaluator {
 public:
  void Evaluate(const GameSettings&, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const State& state = *positions[i].state;
      const auto viewer = static_cast<std::size_t>(positions[i].viewer);
      EXPECT_TRUE(state.agents[viewer].alive);
      Rng rng(state.bomb_cells.low() ^ state.step ^ viewer);
      for (const AgentState& agent : state.agents) rng = rng.Split(agent.cell);
      float total = 0;
      for (float& share : evaluations[i].policy) {
        share = static_cast<float>(rng.Uniform());
        total += share;
      }
      for (float& share : evaluations[i].policy) share /= total;
      evaluations[i].value = static_cast<float>(2 * rng.Uniform() - 1);
      for (auto& shares : evaluations[i].others) {
        for (std::uint8_t& share : shares) share = static_cast<std::uint8_t>(rng.Below(85));
      }
    }
  }
  [[nodiscard]] std::string name() const override { return "hash"; }
};

}  // namespace powderkeg

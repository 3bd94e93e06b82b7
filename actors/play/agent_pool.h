#pragma once

// The agents of many games side by side.

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <vector>

#include "actors/play/agent.h"
#include "actors/play/factory.h"

namespace powderkeg {

// One agent for each slot, seat and specification, made when first needed and then reused: trees
// are large. One thread.
class AgentPool {
 public:
  explicit AgentPool(std::vector<AgentSpec> specs) : specs_(std::move(specs)) {}

  // For a game in `slot`, in which nobody else uses it. Requires that specs[spec] is no rule-based
  // policy.
  [[nodiscard]] Agent* At(int slot, AgentId seat, std::size_t spec) {
    std::unique_ptr<Agent>& agent = agents_[{slot, seat, static_cast<int>(spec)}];
    if (agent == nullptr) agent = MakeAgent(specs_[spec]);
    return agent.get();
  }

 private:
  std::vector<AgentSpec> specs_;
  std::map<std::array<int, 3>, std::unique_ptr<Agent>> agents_;
};

}  // namespace powderkeg

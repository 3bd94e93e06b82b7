#pragma once

// The memory of search trees, which nobody sees in simulations=1000000.

#include <cstddef>
#include <string_view>

#include "common/config/agent_spec.h"
#include "common/config/run_config.h"

namespace powderkeg {

inline constexpr std::size_t kTreeNodeBytes = 546;  // what is kept for a node (tree.h)

// What the tree of one game takes, from the first move on; with tree_reuse it grows. 0: no search.
[[nodiscard]] std::size_t TreeBytes(const AgentSpec& agent);

// Of the trees of one game loop of an actor, once every player has played in every seat.
[[nodiscard]] std::size_t TreeBytesOfLoop(const SelfPlayConfig& config);

// Says in one line of the log how much the trees of `whose` take if that is half a gigabyte or
// more.
void WarnOfTrees(std::string_view whose, std::size_t bytes);
// The same on the machine that will hold them. Throws Error if it has less.
void RequireMemoryForTrees(std::string_view whose, std::size_t bytes);

}  // namespace powderkeg

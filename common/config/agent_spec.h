#pragma once

// Agents as text: what users write on command lines and in settings files.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/config/pessimist_settings.h"
#include "common/config/search_settings.h"
#include "common/policies/policy.h"

namespace powderkeg {

// What computes networks, and in what arithmetic; auto: what suits the machine.
inline constexpr std::array<std::string_view, 4> kEvaluatorNames = {"auto", "uniform", "torch",
                                                                    "onednn"};
inline constexpr std::array<std::string_view, 5> kPrecisionNames = {"auto", "fp32", "bf16", "fp16",
                                                                    "int8"};

// An agent and, where its text says so, its model.
struct AgentSpec {
  enum class Kind : std::uint8_t { kRuleBased, kPessimist, kRawNetwork, kSearch };
  std::string text;  // as written
  Kind kind = Kind::kRuleBased;
  PolicyKind policy = PolicyKind::kIdle;  // of kRuleBased
  PessimistSettings pessimist;            // of kPessimist
  SearchSettings search;                  // of kSearch
  std::string model_file;                 // empty: the uniform evaluator, or named elsewhere

  [[nodiscard]] bool HasNetwork() const {
    return kind == Kind::kRawNetwork || kind == Kind::kSearch;
  }
  friend bool operator==(const AgentSpec&, const AgentSpec&) = default;
};

// Reads
//   idle, random, harmless, simple_unbiased, official_simple   a rule-based policy
//   pessimist[:OPTION=VALUE,...]                               looks ahead on bit boards
//   raw:model=FILE                                             the network's best move
//   search[:OPTION=VALUE,...][,model=FILE]                     a search (search_options.inc)
// FILE is a weights file or untrained:NETWORK. Throws Error with what is wrong and what is known.
[[nodiscard]] AgentSpec ParseAgent(std::string_view text);
// The same without model=FILE, for players, whose weights are named beside the agent; a search's
// options change `base`.
[[nodiscard]] AgentSpec ParsePlayersAgent(std::string_view text, const SearchSettings& base);

// Whether the name alone is an agent without weights: a policy or pessimist.
[[nodiscard]] bool IsScript(std::string_view name);

// What ParseAgent reads, separated by ", ": for error messages and --help.
[[nodiscard]] std::string KnownAgents();
// Every option of a search and of a pessimist with default, meaning and range, for --help-options.
[[nodiscard]] std::string AgentOptionsHelp();

}  // namespace powderkeg

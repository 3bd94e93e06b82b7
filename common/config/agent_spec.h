#pragma once

// Agents as text: what users write on command lines and in settings files.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/config/foreign_settings.h"
#include "common/config/pessimist_settings.h"
#include "common/config/search_settings.h"
#include "common/policies/policy.h"

namespace powderkeg {

// What computes networks, and in what arithmetic; auto: what suits the machine.
inline constexpr std::array<std::string_view, 4> kEvaluatorNames = {"auto", "uniform", "torch",
                                                                    "onednn"};
inline constexpr std::array<std::string_view, 5> kPrecisionNames = {"auto", "fp32", "bf16", "fp16",
                                                                    "int8"};

// Agents without weights, whose name alone is one: the rule-based policies, and the pessimist.
inline constexpr std::array<std::string_view, 6> kScriptNames = {
    "idle", "random", "harmless", "simple_unbiased", "official_simple", "pessimist"};

// An agent and, where its text says so, its model.
struct AgentSpec {
  enum class Kind : std::uint8_t { kRuleBased, kPessimist, kRawNetwork, kSearch, kForeign };
  std::string text;  // as written
  Kind kind = Kind::kRuleBased;
  PolicyKind policy = PolicyKind::kIdle;  // of kRuleBased
  PessimistSettings pessimist;            // of kPessimist
  SearchSettings search;                  // of kSearch
  ForeignSettings foreign;                // of kForeign
  std::string model_file;  // as named; empty: the uniform evaluator, or named elsewhere

  [[nodiscard]] bool HasNetwork() const {
    return kind == Kind::kRawNetwork || kind == Kind::kSearch;
  }
  friend bool operator==(const AgentSpec&, const AgentSpec&) = default;
};

// Reads
//   idle, random, harmless, simple_unbiased, official_simple   a rule-based policy
//   pessimist[:OPTION=VALUE,...]                               looks ahead on bit boards
//   raw:model=MODEL                                            the network's best move
//   search[:OPTION=VALUE,...][,model=MODEL]                    a search (search_options.inc)
//   http:HOST:PORT[,OPTION=VALUE,...]                          a server of the official protocol
// MODEL is a weights file or a name (common/model/model_name.h). Throws Error with what is wrong
// and what is known.
[[nodiscard]] AgentSpec ParseAgent(std::string_view text);
// The same without model=MODEL and http:HOST:PORT, for players, whose weights are named beside the
// agent; a search's options change `base`.
[[nodiscard]] AgentSpec ParsePlayersAgent(std::string_view text, const SearchSettings& base);

// Whether it is one of kScriptNames.
[[nodiscard]] bool IsScript(std::string_view name);

// Throws Error if a server of the official protocol, which plays one seat at a time, has two.
void CheckServers(std::span<const AgentSpec> seats);

// What ParseAgent reads, separated by ", ": for error messages and --help.
[[nodiscard]] std::string KnownAgents();
// Every option of a search, a pessimist and a server with default, meaning and range, for
// --help-options.
[[nodiscard]] std::string AgentOptionsHelp();

}  // namespace powderkeg

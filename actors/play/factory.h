#pragma once

// Agents from text: what users write on command lines and in config files.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "actors/play/agent.h"
#include "actors/play/evaluation_batches.h"
#include "actors/search/search_settings.h"
#include "common/policies/policy.h"

namespace powderkeg {

// A parsed agent specification.
struct AgentDescription {
  enum class Kind : std::uint8_t { kRuleBased, kRawNetwork, kSearch };
  std::string text;  // as written
  Kind kind = Kind::kRuleBased;
  PolicyKind policy = PolicyKind::kIdle;  // of kRuleBased
  SearchSettings search;                  // of kSearch
  std::string model_file;                 // empty: the uniform evaluator
};

// Reads
//   idle, random, harmless, simple_unbiased, official_simple   a rule-based policy
//   raw:model=FILE                                             the network's best move
//   search[:OPTION=VALUE,...][,model=FILE]                     a search (search_settings.h)
// FILE is a weights file or untrained:NETWORK. Throws Error with what is wrong and what is known.
[[nodiscard]] AgentDescription ParseAgent(std::string_view text);
// What ParseAgent reads, separated by ", ": for error messages and --help.
[[nodiscard]] std::string KnownAgents();

// The agent; its questions are for the description's model.
[[nodiscard]] std::unique_ptr<Agent> MakeAgent(const AgentDescription& description);

// Loads a weights file for one thread. Only a main knows evaluators that compute; throws Error.
using ModelLoader = std::function<Model(const std::string& file)>;

// The uniform evaluator, or what the loader makes of the model file.
[[nodiscard]] Model MakeModel(const std::string& model_file, const ModelLoader& loader);

}  // namespace powderkeg

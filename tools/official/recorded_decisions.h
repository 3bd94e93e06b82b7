#pragma once

// Decisions recorded from the original rule-based agents, and the comparison of our policies with
// them. Formats: what every field is named after in the original observation; one JSON object per
// line (tests/data/simple_unbiased.jsonl.gz, tests/data/simple_agent.jsonl.gz).

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/policies/policy.h"

namespace powderkeg {

// One decision of the original agent and how often it chose what, asked again and again with other
// random numbers.
struct RecordedDecision {
  State state;  // what the agent saw; agents it did not see are not alive here
  GameSettings settings;
  AgentId self = 0;
  BitBoard visible;
  PolicyMemory memory;                     // before the decision
  std::array<int, kActionCount> counts{};  // by action
  int errors = 0;                          // calls in which the original failed
  std::optional<Action> chosen;            // in the recorded game, where known
  PolicyMemory memory_after;               // of that call
};

// Reads one line for an agent of this kind (kSimpleUnbiased or kOfficialSimple). Throws Error on
// anything else than such a record.
[[nodiscard]] RecordedDecision ParseRecordedDecision(PolicyKind kind, const std::string& line);

// Asks the policy many times with fresh random numbers and hidden orders. A record with one action
// must be met in every call; the others are compared by a chi-squared test of homogeneity at
// `significance`, the probability of refusing a correct policy. kMayBeChance compares records with
// one action by the test as well. Returns the difference in words, or nullopt.
enum class SingleAction : std::uint8_t { kIsCertain, kMayBeChance };
[[nodiscard]] std::optional<std::string> CompareDecision(PolicyKind kind,
                                                         const RecordedDecision& record,
                                                         double significance, SingleAction single,
                                                         Rng rng);

// Checks whole files for the agent "simple_unbiased" or "official_simple", with a family-wise error
// rate of 1 % per file. Prints to standard output "FILE: N checked, M differences, K skipped" after
// the first differences in full. Returns 0 if nothing differs, else 1. Throws Error on an unknown
// agent or unreadable input.
[[nodiscard]] int RunDecisionsCheck(const std::string& agent,
                                    const std::vector<std::string>& files);

}  // namespace powderkeg

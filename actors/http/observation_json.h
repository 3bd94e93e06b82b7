#pragma once

// What the official runner sends, as values (docs/spec/http_agent_protocol.md). Every body is one
// JSON object whose values are JSON texts in strings: {"id": "2", "game_type": "1"}.
//
// Total functions: whatever the bytes are, the answer is a value or the reason why not. Bodies are
// nested at most kMaxJsonDepth deep; what lies deeper is dropped unread.

#include <string>
#include <string_view>
#include <variant>

#include "common/pommerman/game_settings.h"
#include "common/pommerman/observation.h"

namespace powderkeg {

inline constexpr int kMaxJsonDepth = 4;

// Why a body was not understood: one line that says what, which value, what was expected.
struct Refusal {
  std::string reason;
};

template <typename Value>
using Parsed = std::variant<Value, Refusal>;

// POST /init_agent: who plays what.
struct InitRequest {
  AgentId id;
  Mode mode;

  friend bool operator==(const InitRequest&, const InitRequest&) = default;
};
[[nodiscard]] Parsed<InitRequest> ParseInitRequest(std::string_view body);

// POST /action: what the agent sees, and the environment this can come from.
struct ActionRequest {
  Observation observation;
  // Of the registered environment with this game type, this view (fog or none on the board) and
  // this version (only v1 collapses).
  GameSettings settings;

  friend bool operator==(const ActionRequest&, const ActionRequest&) = default;
};
// Accepts what the official environment can show a living agent and nothing else: numbers in range,
// whole (written as 9 or 9.0), and consistent with each other (agents on the board are alive, bombs
// and flames show in every array that tells of them, fog lies just where the view ends). The field
// action_space says nothing that game_type does not and is not read.
[[nodiscard]] Parsed<ActionRequest> ParseActionRequest(std::string_view body);

// POST /episode_end: the last reward of the agent, -1, 0 or +1.
[[nodiscard]] Parsed<int> ParseEpisodeEnd(std::string_view body);

}  // namespace powderkeg

#pragma once

// What the official runner sends, as values (docs/spec/http_agent_protocol.md). Every body is one
// JSON object whose values are JSON texts in strings, {"id": "2", "game_type": "1"}, or the JSON
// values themselves.
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
  // this version (only v1 collapses). As far as can be seen a game that goes on after its last step
  // has no last step.
  GameSettings settings;
  // The keys that were missing, with ", " between: what they would say is believed.
  std::string believed;
  bool step_known = true;  // false: 0 stands in observation.step

  friend bool operator==(const ActionRequest&, const ActionRequest&) = default;
};
// Accepts whatever shows where a living agent stands and what is around it: board, position and
// game_type. Other versions of the environment leave out or count differently what else there is:
// numbers out of range become the nearest that is in range, what is missing is believed (flames and
// bombs are fresh, nothing rolls, nobody kicks), and where an array contradicts the board, the
// board counts. The observation is then one that the official environment could have shown, but for
// the shape of the fog. teammate, enemies and action_space say nothing that game_type does not and
// are not read.
[[nodiscard]] Parsed<ActionRequest> ParseActionRequest(std::string_view body);

// POST /episode_end: the last reward of the agent, -1, 0 or +1.
[[nodiscard]] Parsed<int> ParseEpisodeEnd(std::string_view body);

}  // namespace powderkeg

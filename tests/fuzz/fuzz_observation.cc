// Whatever a runner sends, the answer is a reason or an observation that the belief can take in.
//
// The first byte chooses what the others are: the body, the text within the body, or edits of the
// observations of a real game, which come much nearer to what is accepted.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "actors/http/observation_json.h"
#include "actors/runner/runner_json.h"
#include "common/base/check.h"
#include "common/pommerman/belief.h"
#include "common/pommerman/generate.h"

namespace powderkeg {
namespace {

constexpr const char* kEnvironments[] = {"PommeFFACompetition-v0", "PommeFFA-v1", "PommeTeam-v0",
                                         "PommeRadioCompetition-v2"};
constexpr const char* kGrids[] = {"board", "bomb_life", "bomb_blast_strength",
                                  "bomb_moving_direction", "flame_life"};
constexpr std::size_t kEditBytes = 3;

// One number of one array for every three bytes: which array, which cell, which number.
void Edit(std::string_view bytes, nlohmann::ordered_json& object) {
  for (; bytes.size() >= kEditBytes; bytes.remove_prefix(kEditBytes)) {
    const int grid = static_cast<std::uint8_t>(bytes[0]) % 5;
    const int cell = static_cast<std::uint8_t>(bytes[1]) % kCellCount;
    object[kGrids[grid]][RowOf(cell)][ColumnOf(cell)] = static_cast<std::uint8_t>(bytes[2]) % 14;
  }
}

void ObserveIfAccepted(const std::string& body, const GameSettings& settings, Belief& belief) {
  const auto parsed = ParseActionRequest(body);
  if (const auto* refusal = std::get_if<Refusal>(&parsed)) {
    CHECK(!refusal->reason.empty() && refusal->reason.find('\n') == std::string::npos);
    return;
  }
  const auto& request = std::get<ActionRequest>(parsed);
  if (!(request.settings == settings)) belief = Belief(request.settings);
  belief.Observe(request.observation);
  CHECK(belief.state().agents[request.observation.self].alive);
}

// Two observations in a row, each with half of the edits.
void ObserveEdited(std::string_view bytes) {
  if (bytes.empty()) return;
  const GameSettings settings = *GameSettingsFor(kEnvironments[bytes[0] & 3]);
  State state = GenerateStart(settings, {}, Rng(bytes.size()));
  Belief belief(settings);
  bytes.remove_prefix(1);
  for (const std::string_view half :
       {bytes.substr(0, bytes.size() / 2), bytes.substr(bytes.size() / 2)}) {
    auto object = ObservationObject(settings, Observe(settings, state, 0));
    Edit(half, object);
    ObserveIfAccepted(ActionBody(object), settings, belief);
    ++state.step;
  }
}

void ParseAnything(std::string_view bytes) {
  const auto parsed = ParseActionRequest(bytes);
  (void)ParseInitRequest(bytes);
  (void)ParseEpisodeEnd(bytes);
  CHECK(std::holds_alternative<Refusal>(parsed) ||
        std::get<ActionRequest>(parsed).observation.self < kAgentCount);
}

// The bytes as a JSON string; what is no UTF-8 is replaced.
std::string Wrapped(std::string_view bytes) {
  const nlohmann::json body = {{"obs", bytes}};
  return body.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace
}  // namespace powderkeg

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 3) {
    case 0: powderkeg::ParseAnything(bytes); break;
    case 1: powderkeg::ParseAnything(powderkeg::Wrapped(bytes)); break;
    default: powderkeg::ObserveEdited(bytes); break;
  }
  return 0;
}

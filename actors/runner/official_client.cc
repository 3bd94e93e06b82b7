#include "actors/runner/official_client.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "actors/runner/runner_json.h"
#include "common/base/check.h"
#include "common/base/log.h"
#include "common/http/http_client.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;
using Json = nlohmann::json;

// The official runner's patience for all but moves.
constexpr milliseconds kOthers{500};

// The whole number, if it is one in [0, most].
std::optional<int> Number(const Json& value, int most) {
  if (!value.is_number_integer() || value < 0 || value > most) return std::nullopt;
  return value.get<int>();
}

// What the environment takes as an action: a number or, in radio games, also [action, word, word].
std::optional<RunnerMove> MoveIn(const Json& action, Mode mode) {
  constexpr int kMostAction = kActionCount - 1;
  constexpr int kMostWord = 255;  // the environment does not look at them
  RunnerMove move;
  std::optional<int> number = Number(action, kMostAction);
  if (mode == Mode::kTeamRadio && action.is_array() && action.size() == 1 + move.words.size()) {
    number = Number(action[0], kMostAction);
    for (std::size_t i = 0; i < move.words.size(); ++i) {
      const std::optional<int> word = Number(action[i + 1], kMostWord);
      if (!word) return std::nullopt;
      move.words[i] = static_cast<std::uint8_t>(*word);
    }
  }
  if (!number) return std::nullopt;
  move.action = static_cast<Action>(*number);
  return move;
}

std::optional<RunnerMove> MoveOf(const std::string& body, Mode mode) {
  constexpr int kDepth = 3;
  const auto keep = [](int depth, Json::parse_event_t, const Json&) { return depth <= kDepth; };
  const Json reply = Json::parse(body, keep, /*allow_exceptions=*/false);
  if (!reply.is_object() || !reply.contains("action")) return std::nullopt;
  return MoveIn(reply["action"], mode);
}

// The beginning of what a stranger said, quoted on one line.
std::string Excerpt(const std::string& body) {
  constexpr std::size_t kLongest = 60;
  const Json text = body.substr(0, kLongest);
  return text.dump(-1, ' ', /*ensure_ascii=*/true, Json::error_handler_t::replace);
}

}  // namespace

void OfficialClient::Ping() const {
  const Clock::time_point until = Clock::now() + std::chrono::seconds(settings_.start_s);
  milliseconds pause{500};
  do {
    const auto left = std::max(kOthers, std::chrono::ceil<milliseconds>(until - Clock::now()));
    const HttpAnswer answer = HttpGet(settings_.server, "/ping", {.silence = left, .whole = left});
    if (answer.end == HttpAnswer::End::kAnswered) return;
    log::Info("waiting for an agent", "http", settings_.server.text());
    std::this_thread::sleep_until(std::min(until, Clock::now() + pause));
    pause *= 2;
  } while (Clock::now() < until);
  Fail("no answer to /ping in ", settings_.start_s,
       " s; expected a server of the official protocol");
}

int OfficialClient::Initialise(AgentId agent, Mode mode) const {
  return Tell("/init_agent", InitBody(agent, mode));
}

int OfficialClient::EndEpisode(int reward) const {
  return Tell("/episode_end", StrCat(R"({"reward": ")", reward, R"("})"));
}

int OfficialClient::Shutdown() const { return Post("/shutdown", "{}", kOthers).status; }

RunnerMove OfficialClient::Act(const GameSettings& settings, const Observation& observation) const {
  const HttpAnswer answer =
      Post("/action", ActionBody(settings, observation), milliseconds(settings_.move_ms));
  if (answer.end == HttpAnswer::End::kTimedOut) return {.late = true};
  if (answer.end == HttpAnswer::End::kFailed) {
    Fail("step ", observation.step, ": no whole answer to /action");
  }
  std::optional<RunnerMove> move = MoveOf(answer.body, settings.mode);
  if (!move) {
    Fail("step ", observation.step, ": /action is answered with ", Excerpt(answer.body),
         R"(; expected {"action": 0 to 5)",
         settings.mode == Mode::kTeamRadio ? " or [0 to 5, word, word]}" : "}");
  }
  move->status = answer.status;
  return *move;
}

HttpAnswer OfficialClient::Post(const char* path, const std::string& body,
                                milliseconds silence) const {
  constexpr milliseconds kMore{2000};
  return HttpPostJson(settings_.server, path, body, {.silence = silence, .whole = silence + kMore});
}

int OfficialClient::Tell(const char* path, const std::string& body) const {
  const HttpAnswer answer = Post(path, body, std::max(kOthers, milliseconds(settings_.move_ms)));
  if (answer.end == HttpAnswer::End::kFailed) Fail("no whole answer to ", path);
  return answer.status;
}

template <typename... Parts>
void OfficialClient::Fail(const Parts&... parts) const {
  throw Error(StrCat("agent http:", settings_.server.text(), ": ", parts...));
}

}  // namespace powderkeg

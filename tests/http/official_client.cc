#include "tests/http/official_client.h"

#include <httplib.h>

#include <utility>

#include "common/base/check.h"
#include "tests/http/runner_json.h"

namespace powderkeg {
namespace {

using Json = nlohmann::json;

// Whether the environment would take this as an action.
bool Acceptable(const Json& action, Mode mode) {
  const auto number = [](const Json& value, int most) {
    return value.is_number_integer() && value >= 0 && value <= most;
  };
  if (mode != Mode::kTeamRadio) return number(action, kActionCount - 1);
  return action.is_array() && action.size() == 3 && number(action[0], kActionCount - 1) &&
         number(action[1], 8) && number(action[2], 8);
}

void Read(const std::string& answer, Mode mode, RunnerMove& move) {
  const Json reply = Json::parse(answer, nullptr, /*allow_exceptions=*/false);
  if (!reply.is_object() || !reply.contains("action") || !Acceptable(reply["action"], mode)) {
    move.failure = "no action: " + answer;
    return;
  }
  const Json& played = reply["action"];
  move.action = static_cast<Action>(played.is_array() ? played[0].get<int>() : played.get<int>());
  if (played.is_array()) {
    move.words = {played[1].get<std::uint8_t>(), played[2].get<std::uint8_t>()};
  }
}

}  // namespace

OfficialClient::OfficialClient(std::string url, std::chrono::milliseconds timeout)
    : url_(std::move(url)), timeout_(timeout) {}

std::string OfficialClient::Ping() const {
  httplib::Client client(url_);
  return client.Get("/ping") ? "" : "no answer to /ping";
}

std::string OfficialClient::Initialise(AgentId agent, Mode mode) const {
  return Post("/init_agent", InitBody(agent, mode)).failure;
}

std::string OfficialClient::EndEpisode(int reward) const {
  return Post("/episode_end", StrCat(R"({"reward": ")", reward, R"("})")).failure;
}

std::string OfficialClient::Shutdown() const { return Post("/shutdown", "{}").failure; }

RunnerMove OfficialClient::Act(const GameSettings& settings, const Observation& observation) const {
  const std::string body = ActionBody(settings, observation);
  const auto start = std::chrono::steady_clock::now();
  const Answer answer = Post("/action", body);
  RunnerMove move;
  move.failure = answer.failure;
  move.duration = std::chrono::steady_clock::now() - start;
  if (move.failure.empty()) Read(answer.body, settings.mode, move);
  return move;
}

OfficialClient::Answer OfficialClient::Post(const char* path, const std::string& body) const {
  httplib::Client client(url_);
  client.set_connection_timeout(timeout_);
  client.set_read_timeout(timeout_);
  const auto result = client.Post(path, body, "application/json");
  if (result && result->status == 200) return {.body = result->body, .failure = {}};
  return {.body = {},
          .failure = StrCat(path, ": ", result ? result->body : to_string(result.error()))};
}

}  // namespace powderkeg

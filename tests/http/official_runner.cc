#include "tests/http/official_runner.h"

#include <arpa/inet.h>
#include <httplib.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/base/check.h"
#include "common/pommerman/generate.h"
#include "common/pommerman/observation.h"
#include "common/pommerman/step.h"
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

}  // namespace

OfficialRunner::OfficialRunner(const GameSettings& settings,
                               const std::array<int, kAgentCount>& ports)
    : settings_(settings), ports_(ports) {}

void OfficialRunner::Start() {
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    httplib::Client client("127.0.0.1", ports_[agent]);
    if (!client.Get("/ping")) Fail(agent, "no answer to /ping");
    (void)Post(agent, "/init_agent", InitBody(agent, settings_.mode));
  }
  started_ = true;
}

GameReport OfficialRunner::PlayGame(std::uint64_t seed, int max_steps) {
  failure_.clear();
  if (!started_) Start();
  State state = GenerateStart(settings_, {}, Rng(seed));
  Outcome outcome;
  // Observations are taken before a collapse.
  while (!outcome.done && state.step < max_steps && failure_.empty()) {
    JointAction actions{};
    std::array<Message, kAgentCount> words{};
    for (AgentId agent = 0; agent < kAgentCount; ++agent) {
      const auto i = static_cast<std::size_t>(agent);
      if (state.agents[i].alive) actions[i] = Ask(agent, state, words[i]);
    }
    Collapse(settings_, state);
    Step(settings_, actions, words, state);
    outcome = OutcomeOf(settings_, state);
  }
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    (void)Post(agent, "/episode_end", R"({"reward": "-1"})");
  }
  return {.steps = state.step, .failure = failure_};
}

void OfficialRunner::Close() {
  for (AgentId agent = 0; agent < kAgentCount; ++agent) (void)Post(agent, "/shutdown", "{}");
}

Action OfficialRunner::Ask(AgentId agent, const State& state, Message& words) {
  const std::string answer =
      Post(agent, "/action", ActionBody(settings_, Observe(settings_, state, agent)));
  const Json reply = Json::parse(answer, nullptr, /*allow_exceptions=*/false);
  if (!reply.is_object() || !reply.contains("action") ||
      !Acceptable(reply["action"], settings_.mode)) {
    Fail(agent, "no action: " + answer);
    return Action::kStop;
  }
  const Json& played = reply["action"];
  if (played.is_array()) words = {played[1].get<std::uint8_t>(), played[2].get<std::uint8_t>()};
  const int action = played.is_array() ? played[0].get<int>() : played.get<int>();
  if (legal_[agent] && (LegalActions(state, agent) >> action & 1) == 0) {
    Fail(agent, "illegal action " + answer);
  }
  return static_cast<Action>(action);
}

std::string OfficialRunner::Post(AgentId agent, const char* path, const std::string& body) {
  httplib::Client client("127.0.0.1", ports_[agent]);
  const auto result = client.Post(path, body, "application/json");
  if (result && result->status == 200) return result->body;
  Fail(agent, StrCat(path, ": ", result ? result->body : to_string(result.error())));
  return {};
}

void OfficialRunner::Fail(AgentId agent, const std::string& what) {
  if (failure_.empty()) failure_ = StrCat("agent ", agent, ": ", what);
}

int Connect(int port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  CHECK(socket >= 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  CHECK(::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0);
  return socket;
}

void SendAll(int socket, const std::string& bytes) {
  std::size_t sent = 0;
  while (sent < bytes.size()) {
    const ssize_t count = ::send(socket, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (count <= 0) return;
    sent += static_cast<std::size_t>(count);
  }
}

std::string ReadToEnd(int socket) {
  std::string all;
  std::array<char, 4096> part{};
  ssize_t count = 0;
  while ((count = ::recv(socket, part.data(), part.size(), 0)) > 0) {
    all.append(part.data(), static_cast<std::size_t>(count));
  }
  ::close(socket);
  return all;
}

std::string ExchangeBytes(int port, const std::string& bytes) {
  const int socket = Connect(port);
  SendAll(socket, bytes);
  ::shutdown(socket, SHUT_WR);
  return ReadToEnd(socket);
}

}  // namespace powderkeg

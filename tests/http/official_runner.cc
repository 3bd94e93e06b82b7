#include "tests/http/official_runner.h"

#include "common/base/check.h"
#include "common/pommerman/generate.h"
#include "common/pommerman/observation.h"
#include "common/pommerman/step.h"

namespace powderkeg {
OfficialRunner::OfficialRunner(const GameSettings& settings,
                               const std::array<int, kAgentCount>& ports)
    : settings_(settings) {
  for (const int port : ports) {  // with patience for sanitizers
    clients_.emplace_back(ForeignSettings{.server = {.port = port}, .move_ms = 5000});
  }
}

void OfficialRunner::Start() {
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    clients_[agent].Ping();
    Expect200(agent, "/init_agent", clients_[agent].Initialise(agent, settings_.mode));
  }
  started_ = true;
}

GameReport OfficialRunner::PlayGame(std::uint64_t seed, int max_steps) {
  try {
    return Play(seed, max_steps);
  } catch (const Error& error) {
    return {.failure = error.what()};
  }
}

GameReport OfficialRunner::Play(std::uint64_t seed, int max_steps) {
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
    Expect200(agent, "/episode_end", clients_[agent].EndEpisode(/*reward=*/-1));
  }
  return {.steps = state.step, .failure = failure_};
}

void OfficialRunner::Close() {
  for (const OfficialClient& client : clients_) client.Shutdown();
}

Action OfficialRunner::Ask(AgentId agent, const State& state, Message& words) {
  const RunnerMove move = clients_[agent].Act(settings_, Observe(settings_, state, agent));
  Expect200(agent, "/action", move.status);
  words = move.words;
  const int action = static_cast<int>(move.action);
  if (legal_[agent] && (LegalActions(state, agent) >> action & 1) == 0) {
    Note(agent, StrCat("illegal action ", action));
  }
  return move.action;
}

void OfficialRunner::Expect200(AgentId agent, const char* path, int status) {
  if (status != 200) Note(agent, StrCat(path, " is answered with status ", status));
}

void OfficialRunner::Note(AgentId agent, const std::string& failure) {
  if (!failure.empty() && failure_.empty()) failure_ = StrCat("agent ", agent, ": ", failure);
}

}  // namespace powderkeg

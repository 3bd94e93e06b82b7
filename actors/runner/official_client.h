#pragma once

// One agent behind HTTP, asked as the official runner asks (docs/spec/http_agent_protocol.md).

#include <chrono>
#include <string>
#include <utility>

#include "common/config/foreign_settings.h"
#include "common/http/http_client.h"
#include "common/pommerman/game_settings.h"
#include "common/pommerman/observation.h"

namespace powderkeg {

// What the runner makes of an answer to /action.
struct RunnerMove {
  Action action = Action::kStop;  // that too where it came late
  Message words{};                // radio games
  bool late = false;
  int status = 0;  // of HTTP; 0: late
};

// Whatever a server does, a call ends: when it is silent, as for the official runner, for move_ms
// (of requests other than /action, for 500 ms if that is more), and anyway 2 s later. What stops
// the official runner throws Error: an answer to /action that is no action, no connection, a
// connection that is cut. A value, one thread.
class OfficialClient {
 public:
  explicit OfficialClient(ForeignSettings settings) : settings_(std::move(settings)) {}

  // Returns when the agent has answered; until then it is asked again and again. Throws Error after
  // start_s.
  void Ping() const;
  // The status of the answer, at which the runner does not look; 0: none came in time, which it
  // does not mind either. Shutdown never throws.
  int Initialise(AgentId agent, Mode mode) const;
  int EndEpisode(int reward) const;
  int Shutdown() const;
  [[nodiscard]] RunnerMove Act(const GameSettings& settings, const Observation& observation) const;

 private:
  [[nodiscard]] HttpAnswer Post(const char* path, const std::string& body,
                                std::chrono::milliseconds silence) const;
  // The status as above.
  [[nodiscard]] int Tell(const char* path, const std::string& body) const;
  template <typename... Parts>
  [[noreturn]] void Fail(const Parts&... parts) const;

  ForeignSettings settings_;
};

}  // namespace powderkeg

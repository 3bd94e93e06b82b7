#pragma once

// One agent behind HTTP, talked to as the official runner does.

#include <chrono>
#include <string>

#include "common/pommerman/game_settings.h"
#include "common/pommerman/observation.h"

namespace powderkeg {

// What the runner makes of an answer to /action.
struct RunnerMove {
  Action action = Action::kStop;  // where there is none
  Message words{};                // radio games
  std::string failure;            // why there is no action; empty: there is one
  std::chrono::duration<double, std::milli> duration{0};  // connection, request and answer
};

// A new connection for each request; values are JSON texts in strings. A value, one thread.
class OfficialClient {
 public:
  // The runner waits 150 ms for an action; it reads as many ms here for every answer.
  explicit OfficialClient(std::string url,
                          std::chrono::milliseconds timeout = std::chrono::seconds(5));

  // What went wrong; empty: nothing.
  [[nodiscard]] std::string Ping() const;
  [[nodiscard]] std::string Initialise(AgentId agent, Mode mode) const;
  [[nodiscard]] std::string EndEpisode(int reward) const;
  [[nodiscard]] std::string Shutdown() const;

  [[nodiscard]] RunnerMove Act(const GameSettings& settings, const Observation& observation) const;

 private:
  struct Answer {
    std::string body;
    std::string failure;
  };
  [[nodiscard]] Answer Post(const char* path, const std::string& body) const;

  std::string url_;
  std::chrono::milliseconds timeout_;
};

}  // namespace powderkeg

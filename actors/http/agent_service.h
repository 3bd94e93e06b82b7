#pragma once

// One agent behind the protocol of the official runner, without sockets.

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "actors/http/observation_json.h"
#include "actors/http/thinker.h"
#include "actors/play/agent.h"
#include "common/model/evaluator.h"

namespace powderkeg {

// A status of HTTP and one JSON object on one line: {"success":true}, {"action":5},
// {"action":[5,2,7]} in radio games, or {"error":"why"} with a status of 400 or above.
struct ServiceReply {
  int status = 200;
  std::string body;
};

struct ServiceSettings {
  // From the arrival of a request for an action to its answer, which is then the best action of the
  // rounds that have ended (thinker.h); 0: as long as the search takes.
  std::chrono::milliseconds move_time{0};
  std::uint64_t seed = 1;
};

// Where the time of a move went.
struct MoveTimes {
  std::chrono::microseconds read{0};   // from the arrival of the request to its observation
  std::chrono::microseconds wait{0};   // for earlier requests and the agent's last round for them
  std::chrono::microseconds think{0};  // the observation taken in and thought about

  [[nodiscard]] std::chrono::microseconds total() const { return read + wait + think; }
};

// What the published rules allow an agent for a move.
inline constexpr std::chrono::milliseconds kPublishedMoveTime{100};

// Counters since the start of the service.
struct ServiceStatistics {
  std::uint64_t games = 0;
  std::uint64_t moves = 0;
  std::uint64_t late_moves = 0;   // over kPublishedMoveTime
  std::uint64_t cut_short = 0;    // answered because the time was up, with what there was
  std::uint64_t stand_ins = 0;    // of these: there was nothing, SimpleUnbiased chose
  std::uint64_t searches = 0;     // moves with simulations
  std::uint64_t simulations = 0;  // of all searches, until they were answered
  std::uint64_t evaluations = 0;  // that the agent asked for until then
  std::uint64_t refused = 0;      // requests answered with an error
  MoveTimes slowest_move;
};

// The call order, as the runner keeps it: InitAgent, then Act while the agent lives, EndEpisode,
// perhaps further games without another InitAgent, Shutdown, and perhaps another InitAgent. Every
// InitAgent and EndEpisode, and every observation that does not follow the last one, starts anew
// with an empty memory. Thread-safe: requests are served one at a time.
class AgentService {
 public:
  using Clock = std::chrono::steady_clock;

  AgentService(std::unique_ptr<Agent> agent, std::shared_ptr<Evaluator> evaluator,
               const ServiceSettings& settings);

  // Lets the agent make a few moves that nobody asked for, so that memory and code are in place
  // when the first game begins. To be called before the first request. (Under a clock InitAgent
  // does so for its kind of game too, in 40 ms; the runner waits 500.)
  void WarmUp();

  // Does not wait for a request that is being served.
  [[nodiscard]] ServiceReply Ping() const;
  // Each takes the body of the request. 400: not understood; 409: not now; Act's refusals carry
  // "action": 0 beside the error, so that the official runner plays on. What the evaluator
  // throws for a move is thrown here.
  [[nodiscard]] ServiceReply InitAgent(std::string_view body);
  [[nodiscard]] ServiceReply Act(std::string_view body, Clock::time_point arrival = Clock::now());
  [[nodiscard]] ServiceReply EndEpisode(std::string_view body);
  // The environment is closed: from now on InitAgent must come first again.
  [[nodiscard]] ServiceReply Shutdown();

  [[nodiscard]] ServiceStatistics statistics() const;

 private:
  // The game being played.
  struct Game {
    GameSettings settings;
    AgentId self;
    int step;  // of the last observation
  };

  [[nodiscard]] ServiceReply Refused(int status, std::string_view reason);
  // Refused, with "stop" for the runner to play on with.
  [[nodiscard]] ServiceReply NoMove(int status, std::string_view reason);
  // Why the request does not fit the last InitAgent; empty if it does.
  [[nodiscard]] std::string Conflict(const ActionRequest& request) const;
  // Says, once, what the observations of this runner do not say; counts its steps if they do not.
  void Believe(ActionRequest& request);
  // Takes the observation into the game, a new one if it does not follow.
  [[nodiscard]] Briefing Observe(const ActionRequest& request);
  // Plays `moves` moves of a game with itself, `time` each at most.
  void Rehearse(const GameSettings& settings, int moves, Clock::duration time);
  void Count(const Thought& thought, const MoveTimes& times);

  const ServiceSettings settings_;
  mutable std::mutex mutex_;  // guards what follows
  std::optional<InitRequest> init_;
  std::optional<Game> game_;
  bool belief_said_ = false;
  ServiceStatistics statistics_;
  Thinker thinker_;
};

}  // namespace powderkeg

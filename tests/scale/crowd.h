#pragma once

// Thousands of simulated actors in one process: real sessions and true games, but for the search
// (seats that would search move at random).

#include <netinet/in.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/bounded_queue.h"
#include "common/base/rng.h"
#include "common/base/worker.h"
#include "common/wire/messages.h"
#include "tests/scale/zmtp_connection.h"

namespace powderkeg {

struct CrowdSettings {
  sockaddr_in learner{};
  std::size_t actors = 1000;
  std::uint32_t loops = 1;    // of each
  int connects_per_s = 2000;  // at most
  double life_s = 0;          // mean, until an actor goes and another comes; 0: all stay
  double games_per_s = 0;     // in all, at most; 0: as fast as they are played
  int players = 1;            // threads that play
};

struct CrowdCounts {
  std::size_t sessions = 0;  // now
  std::uint64_t refused = 0;
  std::uint64_t hung_up = 0;  // sessions that the learner ended
  std::uint64_t games = 0;    // acknowledged
  std::uint64_t rejected = 0;
  std::string last_refusal{};
};

// What took how long, in seconds.
struct CrowdTimes {
  std::vector<float> ack{};  // from a game's sending to its acknowledgement
  // By version of the weights, from the first offer to the last actor that had loaded them, and how
  // many had.
  struct Weights {
    double last_s = 0;
    std::size_t actors = 0;
  };
  std::map<std::uint32_t, Weights> weights{};
};

// Runs on the thread that calls Run; a few more play.
class Crowd {
 public:
  explicit Crowd(const CrowdSettings& settings);
  ~Crowd();
  Crowd(const Crowd&) = delete;
  Crowd& operator=(const Crowd&) = delete;

  // Comes, plays and goes; `look` is called once a second.
  void Run(std::chrono::seconds time, const std::function<void(double seconds)>& look);

  [[nodiscard]] const CrowdCounts& counts() const { return counts_; }
  // Since the last call.
  [[nodiscard]] CrowdTimes TakeTimes();

 private:
  using Clock = std::chrono::steady_clock;

  struct Actor {
    std::uint64_t incarnation = 0;
    std::unique_ptr<ZmtpConnection> connection{};
    bool writes = false;  // whether epoll tells when there is room
    bool welcomed = false;
    bool refused = false;
    Clock::time_point leaves{};
    Clock::time_point next_heartbeat{};
    std::chrono::milliseconds heartbeat{1000};
    std::uint32_t version = 0;  // of the weights that it has
    WeightsOffer offer{};       // of those that it loads
    std::uint64_t loaded_bytes = 0;
    std::uint64_t receipt = 0;
    std::optional<std::uint64_t> asked_with{};          // the receipt
    std::map<std::uint64_t, Clock::time_point> sent{};  // by ticket
  };
  struct Wish {
    std::size_t actor;
    std::uint64_t incarnation;
    std::uint64_t ticket;
    std::uint32_t version;
  };
  struct Played {
    Wish wish;
    SealedGame game;
  };

  void Connect(std::size_t index, Clock::time_point now);
  void Disconnect(std::size_t index, bool hung_up);
  void ConnectSome(Clock::time_point now);
  void HandleEvents();
  void SendPlayed(Clock::time_point now);
  void Beat(Clock::time_point now);
  void Send(Actor& actor, const WireMessage& message);
  void Flush(std::size_t index);
  void Take(std::size_t index, std::string_view bytes);
  void Take(std::size_t index, Actor& actor, const WireMessage& message);
  void TakeAck(std::size_t index, Actor& actor, const Ack& ack);
  void AskForWeights(Actor& actor);
  void TakeChunk(Actor& actor, const WeightsChunk& chunk);
  void Play(const std::stop_token& stop);

  const CrowdSettings settings_;
  int epoll_;
  Rng rng_;
  std::vector<Actor> actors_;
  std::deque<std::size_t> absent_;  // who is to connect
  std::deque<Played> to_send_;
  CrowdCounts counts_;
  CrowdTimes times_;
  std::map<std::uint32_t, Clock::time_point> offered_;  // first, by version
  Clock::time_point began_ = Clock::now();
  std::uint64_t connects_ = 0;
  std::uint64_t games_sent_ = 0;
  std::optional<Welcome> welcome_;  // before the first ticket is given to the players
  BoundedQueue<Wish> wishes_{1 << 22};
  BoundedQueue<Played> played_{1 << 12};
  std::vector<std::unique_ptr<Worker>> players_;
};

}  // namespace powderkeg

#pragma once

// Games of a person against agents, move by move.

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "actors/play/factory.h"
#include "common/http/http_server.h"

namespace powderkeg {

struct PlaySettings {
  GameSettings game;
  StartSettings start{.corners = StartCorners::kPermuted};
  std::array<AgentSpec, kAgentCount - 1> opponents;  // seats 1 to 3; in team modes seat 2 is a mate
  AgentSpec adviser;                                 // a search that gives hints
  ModelLoader loader;
  std::uint64_t seed = 1;
};

// A person sits in seat 0. A game moves on only when the person moves, and no thread waits for one:
// who leaves leaves a position behind. At most 16 games are kept (one where an agent is a server),
// then the one that was asked for longest ago is forgotten. Thread-safe; moves are made one at a
// time, as they share evaluators.
//
// Answers are JSON: what GameStory::TakeNews tells, `searches` (new ones, by agent), `step`,
// `over`, `result` and `winners`; or an HttpError.
class PlayRoom {
 public:
  // Loads the models. Throws Error.
  explicit PlayRoom(PlaySettings settings);
  ~PlayRoom();
  PlayRoom(const PlayRoom&) = delete;
  PlayRoom& operator=(const PlayRoom&) = delete;

  // A new game; its number is `game`, beside what HeadJson says.
  [[nodiscard]] HttpReply Begin();
  // Plays a step, or more once the person is dead. 404: no such game; 409: it stands at another
  // step, or is over; 502: an agent that is a server failed, and the game is given up.
  [[nodiscard]] HttpReply Move(std::uint64_t game, int step, Action action);
  // What the adviser would do: `best`, `visits`, `priors`, `values`, `value`, and `expected`: what
  // it takes each agent to do, or -1. Errors as Move; 409 also for the dead.
  [[nodiscard]] HttpReply Hint(std::uint64_t game, int step);

  [[nodiscard]] const PlaySettings& settings() const { return settings_; }

 private:
  class Table;

  // The game, if it stands at this step; otherwise why not.
  [[nodiscard]] Table* TableAt(std::uint64_t game, int step, HttpReply& refusal);
  [[nodiscard]] const Model& ModelFor(const AgentSpec& agent) const;

  const PlaySettings settings_;
  std::mutex mutex_;                     // guards what follows
  std::map<std::string, Model> models_;  // by file
  std::map<std::uint64_t, std::unique_ptr<Table>> tables_;
  std::uint64_t next_game_ = 1;
  std::uint64_t calls_ = 0;
};

}  // namespace powderkeg

#pragma once

// Several agents measured on the same boards, until a question about them is answered.

#include <optional>
#include <span>
#include <vector>

#include "actors/arena/match.h"
#include "actors/arena/question.h"

namespace powderkeg {

struct ContestSettings {
  MatchSettings match;               // games: at most, of each agent
  std::optional<Question> question;  // of the score difference: about two agents
  int min_games = 100;               // before an answer
};

// Who looks on. Agents are numbered as their line-ups. One call at a time, from any thread.
class ContestWatcher {
 public:
  virtual ~ContestWatcher() = default;
  // The agent starts to play, or plays on.
  virtual void Began(int agent) = 0;
  // A game ended.
  virtual void Played(int agent, const PlayedGame& game) = 0;
  // The question about the agent has come so far.
  virtual void Tested(int agent, const TestState& state) = 0;
  // The agent's games are over, or others play for a while.
  virtual void Paused(int agent) = 0;
};

struct ContestResult {
  Match match;
  std::optional<TestState> test;  // of a question about this agent
};

// Plays a match for each line-up, whose role 0 is measured, and returns a result for each. A win
// rate is asked about each agent on its own; for a score difference the two agents take turns until
// it is answered and have played the same games in the end. Answers depend on games in the order of
// their numbers alone, never on which ended first. Throws Error as MatchPlayer does, and if a score
// difference is asked about other than two agents.
[[nodiscard]] std::vector<ContestResult> PlayContest(std::span<const MatchLineup> lineups,
                                                     const ContestSettings& settings,
                                                     const ModelLoader& loader,
                                                     ContestWatcher& watcher);

}  // namespace powderkeg

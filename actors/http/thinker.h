#pragma once

// An agent that thinks in a thread of its own, so that whoever waits for its move is in time.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>

#include "actors/play/agent.h"
#include "common/base/rng.h"
#include "common/base/worker.h"
#include "common/model/evaluator.h"

namespace powderkeg {

// What an agent is told before it thinks about a move.
struct Briefing {
  GameSettings settings;
  Observation observation;
  // The agent's generator, where a game begins with this observation.
  std::optional<Rng> new_game = std::nullopt;
};

// What came of it.
struct Thought {
  using Clock = std::chrono::steady_clock;

  std::optional<Clock::time_point> began;  // nullopt: the agent has not taken in the briefing
  std::optional<Action> action;            // the best found; nullopt: no round has ended
  Message words{};                         // that go with it in radio games
  MoveStatistics statistics;               // of the search for it
  std::uint64_t evaluations = 0;           // that it took
  bool finished = false;                   // false: cut short
};

// Owns an agent and a thread in which alone the agent is used.
//
// The caller sleeps while the agent thinks, and that is the point. On a busy machine a thread that
// computes has its turns and may sit out many milliseconds in the middle of a round; one that has
// slept has used nothing of its share and gets a core almost at once when its time is up (the fair
// scheduler of Linux). So the caller is there to give the best move of the last round that ended.
//
// Called from one thread at a time.
class Thinker {
 public:
  using Clock = Thought::Clock;

  Thinker(std::unique_ptr<Agent> agent, std::shared_ptr<Evaluator> evaluator);
  // Waits for the round under way.
  ~Thinker() = default;
  Thinker(const Thinker&) = delete;
  Thinker& operator=(const Thinker&) = delete;

  // Tells the agent, which then thinks until its move is decided, or until no other round would end
  // before `until` if it took as long as the longest of this move; there is always one. Does not
  // wait: the move begins when the last round of the one before has ended.
  void Start(const Briefing& briefing, Clock::time_point until);

  // Waits for the thought, but no longer than `answer_by`: then it is cut short at what there is.
  // The round under way is the move's last one, and of a move that has not begun the agent is only
  // told. To be called once after each Start.
  //
  // Rethrows what the evaluator (BadEvaluation for answers that are no numbers) or the agent threw;
  // what they throw later is logged. After an evaluator's exception the agent is given uniform
  // answers, so that it can go on.
  [[nodiscard]] Thought Await(Clock::time_point answer_by);

 private:
  // A move that was asked for.
  struct Move {
    Briefing briefing;
    Clock::time_point until;
    // Guarded by mutex_:
    Thought thought;
    std::exception_ptr failure;
  };

  // The thread's life.
  void Serve(const std::stop_token& stop);
  // The next move, as soon as there is one; nullptr: stop.
  [[nodiscard]] std::shared_ptr<Move> NextMove(const std::stop_token& stop);
  void Ponder(Move& move);
  void Tell(const Briefing& briefing);
  // Questions and answers; false: there were none, the move is decided.
  bool PlayRound(const GameSettings& settings, Thought& thought);
  void Answer(const GameSettings& settings);
  // Hands out a thought; whether its move is still waited for.
  bool Publish(const Thought& thought, Move& move);
  void Fail(std::exception_ptr failure, Move& move);

  const std::unique_ptr<Agent> agent_;  // this and the next two: the thread's
  const std::shared_ptr<Evaluator> evaluator_;
  EvaluationBatch batch_;
  std::mutex mutex_;                         // guards what follows
  std::deque<std::shared_ptr<Move>> moves_;  // not begun, oldest first
  std::shared_ptr<Move> awaited_;            // the last one, from Start to Await's end
  std::condition_variable_any asked_;        // there is a move
  std::condition_variable ended_;            // a thought is finished or has failed
  Worker worker_;                            // last: it uses the others
};

}  // namespace powderkeg

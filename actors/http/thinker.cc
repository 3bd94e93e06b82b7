#include "actors/http/thinker.h"

#include <algorithm>
#include <string>
#include <utility>

#include "actors/play/evaluation_batches.h"
#include "common/base/check.h"
#include "common/base/log.h"

namespace powderkeg {
namespace {

using Clock = Thinker::Clock;

// Whether there is time for another round.
class Pace {
 public:
  explicit Pace(Clock::time_point until) : until_(until) {}

  // To be asked after each round.
  [[nodiscard]] bool AllowsAnother() {
    const Clock::time_point before = std::exchange(last_, Clock::now());
    longest_round_ = std::max(longest_round_, last_ - before);
    return last_ + longest_round_ <= until_;
  }

 private:
  Clock::time_point until_;
  Clock::time_point last_ = Clock::now();
  Clock::duration longest_round_{0};
};

std::string ReasonOf(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace

Thinker::Thinker(std::unique_ptr<Agent> agent, std::shared_ptr<Evaluator> evaluator)
    : agent_(std::move(agent)),
      evaluator_(std::move(evaluator)),
      worker_("thinker", [this](const std::stop_token& stop) { Serve(stop); }) {
  CHECK(agent_ != nullptr && evaluator_ != nullptr);
}

// --- The caller --------------------------------------------------------------------------------

void Thinker::Start(const Briefing& briefing, Clock::time_point until) {
  const std::lock_guard lock(mutex_);
  CHECK(awaited_ == nullptr, "Start before Await");
  // What was not told of an earlier game is of no use any more.
  if (briefing.new_game) moves_.clear();
  awaited_ = std::make_shared<Move>();
  awaited_->briefing = briefing;
  awaited_->until = until;
  moves_.push_back(awaited_);
  asked_.notify_one();
}

Thought Thinker::Await(Clock::time_point answer_by) {
  std::unique_lock lock(mutex_);
  CHECK(awaited_ != nullptr, "Await before Start");
  ended_.wait_until(lock, answer_by,
                    [this] { return awaited_->thought.finished || awaited_->failure; });
  const std::shared_ptr<Move> move = std::exchange(awaited_, nullptr);
  if (move->failure) std::rethrow_exception(std::exchange(move->failure, nullptr));
  return move->thought;
}

// --- The thread --------------------------------------------------------------------------------

void Thinker::Serve(const std::stop_token& stop) {
  while (const std::shared_ptr<Move> move = NextMove(stop)) {
    std::exception_ptr failure;
    try {
      Ponder(*move);
    } catch (const std::exception&) {
      failure = std::current_exception();
    }
    if (failure) Fail(std::move(failure), *move);
  }
}

std::shared_ptr<Thinker::Move> Thinker::NextMove(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  asked_.wait(lock, stop, [this] { return !moves_.empty(); });
  if (stop.stop_requested()) return nullptr;
  std::shared_ptr<Move> move = std::move(moves_.front());
  moves_.pop_front();
  return move;
}

void Thinker::Ponder(Move& move) {
  Thought thought;
  thought.began = Clock::now();
  Tell(move.briefing);
  Pace pace(move.until);
  while (Publish(thought, move) && !thought.finished) {
    const bool decided = !PlayRound(move.briefing.settings, thought);
    thought.action = agent_->action();
    thought.words = agent_->words();
    thought.statistics = agent_->move_statistics();
    thought.finished = decided || !pace.AllowsAnother();
  }
}

void Thinker::Tell(const Briefing& briefing) {
  const Observation& observation = briefing.observation;
  if (briefing.new_game) {
    agent_->StartGame(briefing.settings, observation.self, *briefing.new_game);
  }
  agent_->Begin(observation);
}

bool Thinker::PlayRound(const GameSettings& settings, Thought& thought) {
  batch_.Clear();
  if (!agent_->Gather(batch_)) return false;
  Answer(settings);
  agent_->Scatter(batch_);
  thought.evaluations += batch_.size();
  return true;
}

void Thinker::Answer(const GameSettings& settings) {
  try {
    EvaluateBatch(*evaluator_, settings, batch_);
  } catch (...) {
    // Between Gather and Scatter an agent can begin no other move.
    UniformEvaluator().Evaluate(settings, batch_.positions(), batch_.AllocateEvaluations());
    agent_->Scatter(batch_);
    throw;
  }
}

bool Thinker::Publish(const Thought& thought, Move& move) {
  const std::lock_guard lock(mutex_);
  move.thought = thought;
  if (thought.finished) ended_.notify_one();
  return &move == awaited_.get();
}

void Thinker::Fail(std::exception_ptr failure, Move& move) {
  const std::lock_guard lock(mutex_);
  if (&move == awaited_.get()) {
    move.failure = std::move(failure);
    ended_.notify_one();
  } else {
    log::Error("thinking failed after its move was answered", "reason", ReasonOf(failure));
  }
}

}  // namespace powderkeg

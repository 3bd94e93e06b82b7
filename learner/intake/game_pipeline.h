#pragma once

// From a received game to a durable one: verify workers, then one store thread.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/bounded_queue.h"
#include "common/base/worker.h"
#include "common/config/run_config.h"
#include "common/record/game_record.h"
#include "common/record/game_setup.h"
#include "common/wire/messages.h"
#include "common/wire/waker.h"
#include "learner/intake/ticket_office.h"
#include "learner/replay/lessons.h"

namespace powderkeg {

// Makes games durable, in the order given; blocks until they are. `lessons` are those of the games,
// in the same order. Called on the store thread alone, with at least one game, with each ticket at
// most once. May throw Error: that ends the pipeline.
using AppendGames =
    std::function<void(const std::vector<GameRecord>& games, std::vector<Lessons> lessons)>;

struct PipelineSettings {
  SelfPlayConfig self_play;
  int verify_threads = 1;
  // A game waits at most this long for others to be made durable with it.
  std::chrono::milliseconds commit_interval{250};
  std::size_t commit_games = 4096;   // at most, at once
  std::size_t capacity = 65'536;     // games in it
  std::uint32_t newest_version = 0;  // of weights that were published earlier
};

// What became of one submitted game.
struct Verdict {
  SessionId session = 0;  // as submitted
  std::uint64_t ticket = 0;
  std::size_t bytes = 0;  // of the sealed record
  enum class Kind : std::uint8_t { kDurable, kDuplicate, kRejected };
  Kind kind = Kind::kDurable;
  std::string reason;           // of a rejection
  std::size_t decisions = 0;    // of a durable game
  bool other_settings = false;  // played under other settings than the run's
  // Rejected because the run's games are others now: nobody's fault.
  bool outdated = false;
};

// Thread-safe, except that one thread constructs, drains and destroys it.
class GamePipeline {
 public:
  // `stored`: tickets that are durable from earlier. `waker` is notified when there are verdicts.
  // Throws Error if the settings name an unknown environment or policy.
  GamePipeline(PipelineSettings settings, AppendGames append, TicketSet stored, const Waker& waker);
  // Drains; an Error is logged.
  ~GamePipeline();
  GamePipeline(const GamePipeline&) = delete;
  GamePipeline& operator=(const GamePipeline&) = delete;

  // Does not wait. False: full, drained or failed.
  [[nodiscard]] bool Submit(SessionId session, SealedGame game);

  // The verdicts since the last call; every submitted game gets one, unless the pipeline failed.
  // Those of games that became durable together come together: one Ack answers them all, so that
  // the actor's queue does not run over with as many messages as it has games.
  [[nodiscard]] std::vector<Verdict> TakeVerdicts();

  // Actors may have weights of this version from now on.
  void Published(std::uint32_t version) {
    newest_version_ = std::max(version, newest_version_.load());
  }

  // Takes no more games, waits until those in it are durable or rejected and ends the threads.
  // Rethrows the first Error of a thread. May be called again.
  void Drain();

  // Whether a thread ended by an Error.
  [[nodiscard]] bool failed() const;

 private:
  struct SubmittedGame {
    SessionId session;
    SealedGame game;
  };
  struct VerifiedGame {
    Verdict verdict;
    GameRecord record;
    Lessons lessons;
  };

  void RunVerify();
  [[nodiscard]] VerifiedGame Check(const SubmittedGame& submitted) const;
  void RunStore();
  [[nodiscard]] std::vector<VerifiedGame> CollectCommit();
  void Commit(std::vector<VerifiedGame> games);
  void Report(std::vector<Verdict> verdicts);

  const PipelineSettings settings_;
  const Sha256Digest settings_digest_;
  const RunGames games_;
  const AppendGames append_;
  const Waker& waker_;
  TicketSet stored_;  // the store thread's
  std::atomic<std::uint32_t> newest_version_;
  BoundedQueue<SubmittedGame> to_verify_;
  BoundedQueue<VerifiedGame> to_store_;
  mutable std::mutex mutex_;  // guards verdicts_
  std::vector<Verdict> verdicts_;
  std::atomic<bool> drained_ = false;
  std::vector<std::unique_ptr<Worker>> verifiers_;
  std::unique_ptr<Worker> store_;
};

}  // namespace powderkeg

#pragma once

// An actor at work: game loops that play the learner's tickets.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>

#include "actors/selfplay/outbox.h"
#include "actors/selfplay/progress.h"
#include "actors/selfplay/session_client.h"
#include "actors/selfplay/ticket_book.h"
#include "common/config/run_config.h"
#include "common/model/evaluator.h"
#include "common/model/weights_snapshot.h"
#include "common/wire/transport.h"
#include "common/wire/weights_shelf.h"

namespace powderkeg {

// Makes an evaluator for the calling thread, as the run's settings (or the operator) choose. Throws
// Error.
using EvaluatorFactory = std::function<std::unique_ptr<Evaluator>(const SelfPlayConfig& config,
                                                                  const Snapshot& weights)>;

struct SelfPlaySettings {
  SessionClientSettings session;  // its `loops` is the number of threads that play
  std::filesystem::path spool;
  std::size_t outbox_limit_bytes = std::size_t{64} << 20;
  // How long the end waits for games to be acknowledged.
  std::chrono::milliseconds patience{10'000};
};

// Each loop has its own evaluator. New weights are loaded beside the old ones, answer the canary,
// and then serve the games that start from now on (weights_swap at_game_start) or every game in
// play (at_once): a loop may hold two versions for the length of a game. When the learner returns
// with other settings, games in play are given up and their tickets played anew. One thread.
class SelfPlay {
 public:
  // Opens the spool and starts to connect. Throws Error.
  SelfPlay(SelfPlaySettings settings, Connect connect, EvaluatorFactory make_evaluator);

  // Plays until a stop is requested or the learner ends the session; then waits for finished games
  // to be acknowledged (games in play are given up: their tickets go to others) and says goodbye.
  // Throws Error: refused by the learner, no such evaluator, wrong answers to the canary, disk
  // full.
  void Run(const std::stop_token& stop);

  // Whether Run ended because the learner was away for too long.
  [[nodiscard]] bool gave_up() const { return client_.gave_up(); }

 private:
  [[nodiscard]] std::shared_ptr<const Welcome> WaitUntilReady(const std::stop_token& stop) const;
  void Play(const std::stop_token& stop, const std::shared_ptr<const Welcome>& welcome);
  [[nodiscard]] std::optional<Model> ModelOf(std::uint32_t version, const SelfPlayConfig& config,
                                             WeightsShelf<std::shared_ptr<Evaluator>>& evaluators);
  void RunLoop(const std::stop_token& stop, const Welcome& welcome, std::size_t loop);
  [[nodiscard]] Heartbeat Statistics() const;

  const SelfPlaySettings settings_;
  const EvaluatorFactory make_evaluator_;
  Outbox outbox_;
  TicketBook tickets_;
  Progress progress_;
  SessionClient client_;  // last: its thread uses the others
};

}  // namespace powderkeg

#pragma once

// The training side of the learner: games in, weights out, iteration after iteration.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "common/config/run_config.h"
#include "common/model/weights_snapshot.h"
#include "learner/replay/lessons.h"
#include "learner/replay/window.h"
#include "learner/train/checkpoint.h"
#include "learner/train/iteration_report.h"
#include "learner/train/schedule.h"
#include "learner/train/trainer.h"

namespace powderkeg {

// Where a run keeps a version of its weights.
[[nodiscard]] std::filesystem::path WeightsPath(const std::filesystem::path& run_folder,
                                                std::uint32_t version);

struct LearnerLoopSettings {
  TrainingConfig training;
  GameSettings game;             // of every game of the run
  std::filesystem::path folder;  // runs/<name>; holds checkpoints/, weights/
  std::uint64_t seed = 1;        // of the initial weights, the order of samples, the symmetries
  std::optional<TrainerState> first;   // that a new run starts from; none: untrained weights
  std::optional<Precision> precision;  // see TrainerSettings
  std::size_t window_bytes = std::size_t{8} << 30;
};

// All are called on the thread of Run.
struct LearnerLoopHooks {
  // New weights for the actors: once at the start of Run, null if there are none to play with yet,
  // then per iteration.
  std::function<void(const Snapshot&)> publish = [](const Snapshot&) {};
  // Before the checkpoint of an iteration, without which it is repeated, and reported again: what
  // is written of it here is there once it counts as complete. May add to the report; the
  // checkpoint keeps what it returns.
  std::function<std::string(IterationReport&, std::span<const GameResult>)> iteration_trained =
      [](IterationReport&, std::span<const GameResult>) { return std::string(); };
  // After an iteration is complete and durable: a good moment to have the store merged (by the
  // store's own thread).
  std::function<void(const IterationReport&)> iteration_done = [](const IterationReport&) {};
};

// Every version of the weights is saved, and published if it is to be played with (VersionToPlay).
//
// How to wire it:
//   LearnerLoop loop(settings, hooks);                      // resumes from the newest checkpoint
//   if (loop.Wants(0)) loop.AddDemonstrations(games);       // where there are any
//   store.Load(
//       [&](std::uint64_t ticket) {                         // every game stored so far, once
//         known.push_back(ticket);
//         return loop.Wants(ticket);
//       },
//       [&](GameRecord&& game) { loop.Add(LessonsOf(game)); });   // MakeLessons, or an Error
//   pass loop.Add(lessons) for each game that the intake made durable;
//   Worker trainer("trainer", [&](const std::stop_token& stop) { loop.Run(stop); });
// and let no more games be in play than loop.GamesWanted().
//
// A kill at any moment repeats at most the iteration in progress, on the same games (where data
// sets grow, on these and those that have come since): its data set follows from the checkpoint and
// the store. Add, GamesWanted and progress are thread-safe; Run is for one thread.
class LearnerLoop {
 public:
  // Throws Error if the run cannot be resumed or the settings are invalid.
  LearnerLoop(LearnerLoopSettings settings, LearnerLoopHooks hooks);
  ~LearnerLoop();
  LearnerLoop(const LearnerLoop&) = delete;
  LearnerLoop& operator=(const LearnerLoop&) = delete;

  // Whether a game is needed that may have been stored long ago: Add would ignore any other.
  [[nodiscard]] bool Wants(std::uint64_t ticket) const;

  // What the run begins with: games that are played nowhere, with the tickets 0, 1, 2, ... They are
  // the first data set, whatever their number, and no games are wanted until it is learned: they
  // are to be played by those who have learned it. Call it before Add. Throws Error if all of
  // them are held out.
  void AddDemonstrations(std::vector<Lessons> games);

  // The lessons of a game that is durable. Doubles and games of finished iterations are ignored.
  // Does not wait, not even while training.
  void Add(Lessons&& game);

  // Every ticket below it is a demonstration's or belongs to an iteration that was started: it is
  // done, even if its game is stored no more.
  [[nodiscard]] std::uint64_t next_ticket() const;

  // What iteration_trained returned before the checkpoint that the loop was resumed from.
  [[nodiscard]] const std::string& table() const { return table_; }

  // Games below it are not needed after a restart, whichever of the kept checkpoints it goes on
  // from. To be asked in iteration_done: an iteration in progress counts as complete.
  [[nodiscard]] std::uint64_t OldestTicketNeeded() const;

  // How many games, besides those added, are worth playing now (Schedule::GamesWanted): more would
  // be of old weights when their turn comes. Tickets of games that were lost must be handed out
  // again even if it is 0.
  [[nodiscard]] std::uint64_t GamesWanted() const;

  // Runs until every iteration is done or a stop is requested (an iteration in training is then
  // given up, to be repeated after the restart). Throws Error. Call it once, after the stored games
  // were added.
  void Run(const std::stop_token& stop);

  struct Progress {
    int iteration = 0;  // completed ones
    TicketPrefix::Progress games;
    std::uint64_t decisions_wanted = 0;
    TrainingProgress training;  // of the iteration in progress; 0 of 0 while waiting
  };
  [[nodiscard]] Progress progress() const;

 private:
  using Seconds = std::chrono::duration<double>;
  class WaitLog;

  [[nodiscard]] TrainerState FirstOrNewestState();
  void RestoreWindow();
  // Waits for the games of the next iteration; nullopt if stopped.
  [[nodiscard]] std::optional<DataSet> NextDataSet(const std::stop_token& stop);
  [[nodiscard]] bool IsOfItsIteration(const Lessons& game) const;
  static void PassOver(Lessons& game);
  // The games of these tickets that are there.
  [[nodiscard]] std::vector<Lessons> TakeGames(const TicketRange& range);
  [[nodiscard]] DataSet DataSetOf(std::vector<Lessons> games) const;
  [[nodiscard]] DataSet::Part PartOf(std::uint64_t ticket) const;
  // One iteration on its data set; false if stopped.
  bool RunIteration(DataSet data_set, Seconds waited, const std::stop_token& stop);
  [[nodiscard]] TrainingResult Train(int iteration, const std::stop_token& stop);
  void Publish(const TrainerState& state);

  const LearnerLoopSettings settings_;
  const LearnerLoopHooks hooks_;
  CheckpointFolder checkpoints_;
  FirstWeights first_weights_ = FirstWeights::kUntrained;
  std::string table_;
  std::uint32_t version_ = 1;  // of the trainer's weights
  std::unique_ptr<Trainer> trainer_;
  ReplayWindow window_;

  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable_any games_added_;
  Schedule schedule_;                       // iterations are started by the thread of Run alone
  std::map<std::uint64_t, Lessons> games_;  // by ticket: of the next data sets, and, until the
                                            // window is restored, of the completed ones in it
  bool window_restored_ = false;
  bool demonstrated_ = false;  // iteration 1 learns from demonstrations
  TrainingProgress training_progress_;
};

}  // namespace powderkeg

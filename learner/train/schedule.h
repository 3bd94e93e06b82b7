#pragma once

// Iterations as pure logic: which games train which iteration.

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/config/run_config.h"
#include "learner/replay/prefix.h"

namespace powderkeg {

// The learning rate after so many iterations, of which the last may be done in part: from
// learning_rate to final_learning_rate as learning_rate_schedule says.
[[nodiscard]] double LearningRateAfter(const TrainingConfig& training, double iterations);

// What the weights of version 1, before the first iteration, are.
enum class FirstWeights : std::uint8_t { kUntrained, kGiven };

// The version of the weights that actors play with after so many iterations. 0 stands for no
// network (the uniform evaluator), 1 for the weights before the first iteration, k + 1 for those
// after iteration k. Untrained weights are not played with: they know nothing, and cost time.
[[nodiscard]] std::uint32_t VersionToPlay(int iterations_done, FirstWeights first);

// All numbers are positive.
struct ScheduleSettings {
  int iterations = 1;
  std::uint64_t decisions_per_iteration = 1;
  int window_data_sets = 1;
  // Games are played for the next data sets, so many.
  int data_sets_ahead = 2;
  // A data set takes every game that is there without a gap before it; else the first ones that are
  // enough. Which data set a long game is in then depends on when it ended, but it is in one.
  bool growing = false;
};

// Iteration k (from 1) trains on the data sets k - window + 1 to k; its data set is taken when it
// starts. A value; one thread.
class Schedule {
 public:
  // `data_sets` are those of the iterations that were completed before (from a checkpoint).
  explicit Schedule(const ScheduleSettings& settings, std::vector<TicketRange> data_sets = {});

  enum class Use : std::uint8_t {
    kNextDataSets,  // waits for its iteration
    kWindow,        // belongs to the window of completed iterations: needed after a restart
    kNone,          // known already, or of an iteration whose data set left the window
  };
  // What to do with a finished game.
  Use Add(std::uint64_t ticket, std::uint32_t decisions);

  // The games added so far, without a gap from ticket 0 on, are the first data set, however many
  // decisions they hold, and no measure of those that follow. Requires that there are some.
  void CloseFirstDataSet();

  // What Add would do with a game that is not known yet.
  [[nodiscard]] Use UseOf(std::uint64_t ticket) const;

  // Every ticket below it belongs to an iteration that was started, or to a closed data set.
  [[nodiscard]] std::uint64_t next_ticket() const {
    return std::max(prefix_.next_ticket(), closed_games_);
  }

  // The first ticket of the window after the iteration `checkpoints` - 1 before the last one.
  // Requires checkpoints > 0.
  [[nodiscard]] std::uint64_t OldestTicketNeeded(int checkpoints) const;

  // The iteration whose data set a ticket is in; those of no started one are the next one's.
  [[nodiscard]] int IterationOf(std::uint64_t ticket) const;

  // How many games more, besides those added, the data sets ahead need (as far as there are
  // iterations left), by the mean length of the games so far.
  [[nodiscard]] std::uint64_t GamesWanted() const;

  // Starts the next iteration if its games are all there; the range is then its data set.
  [[nodiscard]] std::optional<TicketRange> StartIteration();

  // Games that wait for their iteration count as games without decisions from now on.
  void PassOver() { prefix_.PassOver(); }

  // Whether every iteration was started.
  [[nodiscard]] bool finished() const { return iteration() >= settings_.iterations; }
  // The iteration started last; 0 before the first.
  [[nodiscard]] int iteration() const { return static_cast<int>(data_sets_.size()); }
  // Of all iterations started.
  [[nodiscard]] const std::vector<TicketRange>& data_sets() const { return data_sets_; }
  // Those of them that the next iteration trains on too.
  [[nodiscard]] std::span<const TicketRange> WindowOfNext() const;
  // Of the next iteration.
  [[nodiscard]] TicketPrefix::Progress progress() const { return prefix_.progress(); }
  [[nodiscard]] std::uint64_t decisions_wanted() const {
    return closed_games_ > 0 && data_sets_.empty() ? closed_decisions_
                                                   : settings_.decisions_per_iteration;
  }

 private:
  ScheduleSettings settings_;
  std::vector<TicketRange> data_sets_;
  TicketPrefix prefix_;
  std::uint64_t closed_games_ = 0;  // of a first data set that was closed
  std::uint64_t closed_decisions_ = 0;
  std::uint64_t games_added_ = 0;
  std::uint64_t decisions_added_ = 0;
};

}  // namespace powderkeg

#pragma once

// Runs as they look from outside.

#include <string>

#include "learner/report/figures.h"
#include "learner/report/run_view.h"
#include "tests/learner/report_support.h"

namespace powderkeg {

inline ActorStatistics ActorOf(const std::string& name) {
  ActorStatistics actor;
  actor.name = name;
  actor.heartbeat = {.games = 12,
                     .decisions = 2'400,
                     .simulations = 38'400,
                     .evaluations = 50'000,
                     .batches = 2'000,
                     .games_running = 32,
                     .outbox_games = 3,
                     .outbox_bytes = 4'096,
                     .oldest_game = std::chrono::milliseconds(2'500),
                     .weights_version = 7};
  actor.silence = std::chrono::milliseconds(250);
  actor.tickets = 40;
  actor.games = 11;
  actor.rejected = 1;
  return actor;
}

// The third iteration of a run with two actors.
inline RunView PlayingRun() {
  RunView view{.run = "quick", .started_unix_s = 1'800'000'000};
  view.status.iterations_done = 2;
  view.status.iterations = 40;
  view.status.decisions = 20'000;
  view.status.decisions_wanted = 100'000;
  view.status.actors = 2;
  view.intake = {{.games = 22,
                  .decisions = 4'800,
                  .duplicates = 4,
                  .rejected = 2,
                  .other_settings = 5,
                  .pending_games = 8},
                 /*actors=*/{ActorOf("actor-0"), ActorOf("actor-1")},
                 /*malformed=*/6,
                 /*sessions_lost=*/1,
                 /*tickets_issued=*/102};
  view.last_iteration = ValuesOf(ReportOf(2));
  return view;
}

}  // namespace powderkeg

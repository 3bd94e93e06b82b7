#pragma once

// What a run is doing right now, for programs.

#include <string>

#include "learner/report/run_view.h"

namespace powderkeg {

// One object on one line. All numbers are whole, counters count since the start of the learner:
//
//   run, started_unix_s  its name; when this learner started
//   state                playing, waiting, preparing (games are there, training begins), training,
//                        complete
//   waiting_for          while waiting: "actors", or the missing game, "game 1234"
//   iterations_done, iterations
//   decisions, decisions_wanted      of the next data set
//   decisions_beyond                 in finished games behind one that is missing
//   samples, samples_wanted          of the training, 0 of 0 while there is none
//   intake: games, decisions (durable), games_pending (not yet), duplicates, rejected,
//           other_settings, malformed, sessions_lost, tickets_issued (since the run began): see
//           IntakeStatistics
//   actors: a list by name of
//     name, games, rejected (in this session), tickets (held), silence_ms (since its last message)
//     games_played, decisions, simulations, evaluations, batches (since the actor started)
//     games_running, spool_games, spool_bytes, oldest_game_ms, weights_version (now)
[[nodiscard]] std::string StatusJson(const RunView& view);

}  // namespace powderkeg

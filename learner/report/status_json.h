#pragma once

// What a run is doing right now, for programs.

#include <string>

#include "learner/report/run_view.h"

namespace powderkeg {

// One object on one line. Counters count since the start of the learner, those of an actor since it
// started; null stands for what is no number.
//
//   run, started_unix_s  its name; when this learner started
//   state                playing, waiting, preparing (games are there, training begins), training,
//                        complete
//   waiting_for          while waiting: "actors", or the missing game, "game 1234"
//   RunFigures()
//   intake               IntakeFigures()
//   actors               a list by name: name, ActorFigures()
//   last_iteration       IterationFigures(), once there is one
[[nodiscard]] std::string StatusJson(const RunView& view);

}  // namespace powderkeg

#pragma once

// From game records to what training reads: positions with targets, and how the games went.

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/stats.h"
#include "common/pommerman/state.h"
#include "common/record/game_record.h"

namespace powderkeg {

// One decision as a training example. Planes are encoded when a batch is built.
struct Sample {
  State state;                                     // without hidden items
  std::array<std::uint16_t, kActionCount> visits;  // policy target; all 0: none
  std::uint8_t viewer;                             // the agent that decided
  std::int8_t outcome;                             // +1 win, 0 tie, -1 loss of the viewer
  std::uint16_t end_step;                          // when the record of the game ends
  float search_value;                              // of the search's root, the viewer's view
};

// How the searching agents of some games fared.
struct PlaySummary {
  std::uint64_t games = 0;
  std::uint64_t decisions = 0;
  MatchScore score;  // one result per searching agent and game
  std::uint64_t steps = 0;
  std::array<std::uint64_t, kActionCount> actions{};  // played where a search decided
  // Sum over the games of their weights_version, for the mean; 0 (no network) counts as 1.
  std::uint64_t weights_versions = 0;
};

// Games of one iteration. A value; one thread.
struct DataSet {
  std::vector<Sample> samples;  // in the order in which the games were added
  PlaySummary summary;
};

// Re-plays the game and appends its decisions. Throws Error with the ticket and the reason if the
// record does not verify, which the intake has excluded: the store must then be damaged.
void AddGame(const GameRecord& game, DataSet& data_set);

}  // namespace powderkeg

#pragma once

// Real games for tests of training: agent 0 "searches" (moves at random among the legal actions),
// the others are rule-based.

#include <bit>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/base/rng.h"
#include "common/record/game_record.h"
#include "common/record/rule_based_seat.h"
#include "learner/replay/lessons.h"

namespace powderkeg {

// A legal action and made-up visits that favour it.
inline Action DecideAtRandom(const State& state, Rng& rng, GameRecord& record) {
  const ActionSet legal = LegalActions(state, 0);
  Decision decision;
  decision.step = state.step;
  decision.value = static_cast<float>(rng.Uniform() - 0.5);
  decision.weights_version = record.tracks[0].weights_version;
  std::vector<Action> actions;
  for (int i = 0; i < kActionCount; ++i) {
    if ((legal >> i & 1) == 0) continue;
    actions.push_back(static_cast<Action>(i));
    decision.visits[i] = static_cast<std::uint16_t>(1 + rng.Below(20));
  }
  const Action chosen = actions[rng.Below(static_cast<std::uint32_t>(actions.size()))];
  decision.visits[static_cast<std::size_t>(chosen)] += 40;
  record.tracks[0].decisions.push_back(decision);
  return chosen;
}

// The game of a ticket, to its end or the searching agent's death; it verifies.
inline GameRecord PlayGame(std::uint64_t ticket, std::uint32_t weights_version = 0) {
  GameRecord record;
  record.ticket = ticket;
  record.tracks[0].weights_version = weights_version;
  record.evaluator = "uniform";
  record.setup.seed = Rng(99).Split(ticket).Next();
  record.setup.start.corners = StartCorners::kPermuted;
  record.setup.seats[0] = {.searches = true, .teaches = Teaches::kSearch, .measured = true};
  record.setup.to_the_end = false;
  for (int seat = 1; seat < kAgentCount; ++seat) {
    record.setup.seats[seat].policy = PolicyKind::kSimpleUnbiased;
  }
  const GameSettings& settings = record.setup.settings;
  State state = GenerateStart(settings, record.setup.start, BoardRng(record.setup));
  std::array<RuleBasedSeat, kAgentCount> others;
  for (int seat = 1; seat < kAgentCount; ++seat) others[seat] = RuleBasedSeat(record.setup, seat);
  Rng rng = SearchRng(record.setup, 0);
  while (!record.outcome.done && state.agents[0].alive) {
    JointAction actions{};
    actions[0] = DecideAtRandom(state, rng, record);
    for (int seat = 1; seat < kAgentCount; ++seat) {
      if (state.agents[seat].alive) actions[seat] = others[seat].Decide(settings, state);
    }
    Step(settings, actions, state);
    record.outcome = OutcomeOf(settings, state);
    record.actions.push_back(actions);
  }
  return record;
}

inline Lessons LessonsOf(const GameRecord& game) { return std::get<Lessons>(MakeLessons(game)); }

inline void AddGame(const GameRecord& game, DataSet& data_set) {
  data_set.Add(LessonsOf(game), DataSet::Part::kTraining);
}

inline std::vector<GameRecord> PlayGames(std::uint64_t first_ticket, int count) {
  std::vector<GameRecord> games;
  for (int i = 0; i < count; ++i) {
    games.push_back(PlayGame(first_ticket + static_cast<std::uint64_t>(i)));
  }
  return games;
}

}  // namespace powderkeg

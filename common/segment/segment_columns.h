#pragma once

// The specification of a segment: game records as flat arrays.

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/record/game_record.h"

namespace powderkeg {

// Format of the columns below; written into every segment.
inline constexpr std::uint32_t kSegmentFormat = 3;

// The columns of games, steps and decisions. A value; one thread.
struct SegmentColumns {
  struct Games {
    std::vector<std::uint64_t> ticket;
    std::vector<std::uint64_t> seed;
    std::vector<std::uint8_t> lineup;
    std::vector<std::uint8_t> to_the_end;
    std::vector<std::array<std::uint32_t, kAgentCount>> weights_version;
    std::vector<std::uint64_t> first_step;
    std::vector<std::uint32_t> step_count;
    std::vector<std::uint64_t> first_decision;
    std::vector<std::array<std::uint32_t, kAgentCount>> decision_count;
    std::vector<std::uint32_t> evaluator;
    std::vector<std::uint8_t> mode;
    std::vector<std::uint32_t> board_size;
    std::vector<std::uint32_t> max_steps;
    std::vector<std::uint32_t> blast_strength_cap;
    std::vector<std::uint32_t> view_radius;
    std::vector<std::array<std::uint32_t, 4>> collapse_steps;
    std::vector<std::uint8_t> generator;
    std::vector<std::uint8_t> corners;
    std::vector<std::array<std::uint8_t, kAgentCount>> seat_searches;
    std::vector<std::array<std::uint8_t, kAgentCount>> seat_policy;
    std::vector<std::array<std::uint8_t, kAgentCount>> seat_teaches;
    std::vector<std::array<std::uint8_t, kAgentCount>> seat_measured;
    std::vector<std::array<std::uint8_t, kAgentCount>> seat_player;
    std::vector<std::uint8_t> done;
    std::vector<std::uint8_t> result;
    std::vector<std::uint8_t> winners;
    std::vector<std::array<std::int8_t, kAgentCount>> rewards;
    std::vector<std::uint32_t> checksum;
  };
  struct Steps {
    std::vector<std::uint16_t> actions;
  };
  struct Decisions {
    std::vector<std::uint32_t> game;
    std::vector<std::uint8_t> agent;
    std::vector<std::uint16_t> step;
    std::vector<std::array<std::uint16_t, kActionCount>> visits;
    std::vector<float> value;
    std::vector<std::uint32_t> weights_version;
  };

  Games games;
  Steps steps;
  Decisions decisions;
  std::vector<std::string> evaluators;  // distinct names
};

// Calls visit(name, column, description) for every array of the segment, in a fixed order.
// `Columns` is SegmentColumns, const or not.
template <typename Columns, typename Visit>
void ForEachColumn(Columns& columns, Visit&& visit) {
  auto& games = columns.games;
  visit("games/ticket", games.ticket, "number of the game in start order, and its identity");
  visit("games/seed", games.seed, "start, traits and rule-based decisions follow from it");
  visit("games/lineup", games.lineup, "index among the line-ups of the run");
  visit("games/to_the_end", games.to_the_end, "0: only until no measured agent could win");
  visit("games/weights_version", games.weights_version,
        "per agent, of its network at the start of the game; 0: none");
  visit("games/first_step", games.first_step, "its first row of steps/");
  visit("games/step_count", games.step_count, "its rows of steps/");
  visit("games/first_decision", games.first_decision,
        "its first row of decisions/: agent 0's, then those of agents 1 to 3");
  visit("games/decision_count", games.decision_count, "per agent, its rows of decisions/");
  visit("games/evaluator", games.evaluator, "index into evaluators");
  visit("games/mode", games.mode, "1 free-for-all, 2 team, 3 team with radio, 4 one against one");
  visit("games/board_size", games.board_size, "rows and columns: 11 or 8");
  visit("games/max_steps", games.max_steps, "a game not decided by then is a tie");
  visit("games/blast_strength_cap", games.blast_strength_cap, "cap when an item is picked up");
  visit("games/view_radius", games.view_radius, "cells seen to each side; 0: the whole board");
  visit("games/collapse_steps", games.collapse_steps, "steps until ring k is walls; 0: never");
  visit("games/generator", games.generator, "start positions: 0 official, 1 uniform");
  visit("games/corners", games.corners, "start corners: 0 agent i in corner i, 1 permuted");
  visit("games/seat_searches", games.seat_searches, "per agent; 1: it is no rule-based policy");
  visit("games/seat_policy", games.seat_policy,
        "per agent that does not search: 0 idle, 1 random, 2 harmless, 3 simple_unbiased, "
        "4 official_simple");
  visit("games/seat_teaches", games.seat_teaches,
        "per agent: 0 nothing, 1 what its search found, 2 what it did");
  visit("games/seat_measured", games.seat_measured, "per agent; 1: its result counts");
  visit("games/seat_player", games.seat_player, "per agent, index among the players of the run");
  visit("games/done", games.done, "1: the environment ended the game");
  visit("games/result", games.result, "0 incomplete, 1 win, 2 tie");
  visit("games/winners", games.winners, "bit i: agent i won");
  visit("games/rewards", games.rewards, "per agent: -1, 0, +1");
  visit(
      "games/checksum", games.checksum,
      "CRC-32C of its rows of all columns, as of a segment that holds it alone (this is 0 there), "
      "and of the evaluator's name");
  visit("steps/actions", columns.steps.actions,
        "4 bits an agent, agent 0 lowest: 0 stop, 1 up, 2 down, 3 left, 4 right, 5 bomb");
  auto& decisions = columns.decisions;
  visit("decisions/game", decisions.game, "row of games/");
  visit("decisions/agent", decisions.agent, "0..3");
  visit("decisions/step", decisions.step, "steps played before the decision");
  visit("decisions/visits", decisions.visits,
        "policy target of the search by action, not scaled; all 0: none");
  visit("decisions/value", decisions.value, "of the root, the agent's view, -1 to +1");
  visit("decisions/weights_version", decisions.weights_version, "that answered");
}

[[nodiscard]] SegmentColumns ToColumns(std::span<const GameRecord> games);

// Calls `visit` for each game that agrees with its checksum, in order (the games themselves are not
// verified). Says what is wrong with the last of the others, or with all; empty: nothing.
[[nodiscard]] std::string ForEachWholeGame(const SegmentColumns& columns,
                                           const std::function<void(GameRecord&&)>& visit);

}  // namespace powderkeg

#pragma once

// True games for tests of the session: the searching seat moves at random among the legal actions.

#include <cstdint>
#include <vector>

#include "common/base/rng.h"
#include "common/record/game_record.h"
#include "common/record/game_setup.h"
#include "common/record/rule_based_seat.h"
#include "common/wire/codec.h"

namespace powderkeg {

// Quick games: nobody else does anything.
inline SelfPlayConfig QuickConfig() {
  SelfPlayConfig config;
  config.opponents = {"idle", "random", "simple_unbiased"};
  config.games_in_flight = 4;
  config.evaluator = "uniform";
  return config;
}

// A legal action of the agent, recorded with made-up visits that favour it.
inline Action DecideAtRandom(const State& state, AgentId agent, Rng& rng, GameRecord& record) {
  const ActionSet legal = LegalActions(state, agent);
  Decision decision{.step = state.step};
  decision.value = QuantiseValue(static_cast<float>(rng.Uniform() * 2 - 1));
  decision.weights_version = record.tracks[agent].weights_version + rng.Below(2);
  std::vector<std::size_t> actions;
  for (std::size_t i = 0; i < kActionCount; ++i) {
    if ((legal >> i & 1) == 0) continue;
    actions.push_back(i);
    decision.visits[i] = static_cast<std::uint16_t>(1 + rng.Below(100));
  }
  const std::size_t chosen = actions[rng.Below(static_cast<std::uint32_t>(actions.size()))];
  decision.visits[chosen] = static_cast<std::uint16_t>(decision.visits[chosen] + 150);
  if (record.setup.seats[agent].teaches == Teaches::kSearch) {
    record.tracks[agent].decisions.push_back(decision);
  }
  return static_cast<Action>(chosen);
}

// The game of a ticket up to the searching agent's death or the end; Verify accepts it.
inline GameRecord PlayTicket(const SelfPlayConfig& config, std::uint64_t ticket) {
  GameRecord record;
  record.ticket = ticket;
  record.setup = RunGames(config).SetupFor(ticket);
  record.evaluator = "uniform";
  const GameSetup& setup = record.setup;
  State state = GenerateStart(setup.settings, setup.start, BoardRng(setup));
  std::array<RuleBasedSeat, kAgentCount> rule_based;
  AgentId searching = 0;
  for (AgentId seat = 0; seat < kAgentCount; ++seat) {
    if (setup.seats[seat].searches) {
      searching = seat;
      record.tracks[seat].weights_version = 7;
    } else {
      rule_based[seat] = RuleBasedSeat(setup, seat);
    }
  }
  Rng rng = SearchRng(setup, searching);
  while (!record.outcome.done && state.agents[searching].alive) {
    JointAction actions{};
    for (AgentId seat = 0; seat < kAgentCount; ++seat) {
      if (!state.agents[seat].alive) continue;
      actions[seat] = seat == searching ? DecideAtRandom(state, seat, rng, record)
                                        : rule_based[seat].Decide(setup.settings, state);
    }
    Step(setup.settings, actions, state);
    record.outcome = OutcomeOf(setup.settings, state);
    record.actions.push_back(actions);
  }
  return record;
}

inline SealedGame SealedTicket(const SelfPlayConfig& config, std::uint64_t ticket) {
  return Seal(PlayTicket(config, ticket), Sha256Digest{});
}

}  // namespace powderkeg

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
  const std::uint32_t version = record.tracks[agent].weights_version;
  decision.weights_version = version == 0 ? 0 : version + rng.Below(2);
  std::vector<std::size_t> actions;
  for (std::size_t i = 0; i < kActionCount; ++i) {
    if ((legal >> i & 1) == 0) continue;
    actions.push_back(i);
    decision.visits[i] = static_cast<std::uint16_t>(1 + rng.Below(20));
  }
  const std::size_t chosen = actions[rng.Below(static_cast<std::uint32_t>(actions.size()))];
  decision.visits[chosen] = static_cast<std::uint16_t>(decision.visits[chosen] + 100);
  if (record.setup.seats[agent].teaches == Teaches::kSearch) {
    record.tracks[agent].decisions.push_back(decision);
  }
  return static_cast<Action>(chosen);
}

// The game of a ticket to its end, or until nobody measured can win; Verify accepts it. Decisions
// are by these weights or the next ones; 0: by none.
inline GameRecord PlayTicket(const SelfPlayConfig& config, std::uint64_t ticket,
                             std::uint32_t weights_version = 0) {
  GameRecord record;
  record.ticket = ticket;
  record.setup = RunGames(config).SetupFor(ticket);
  record.evaluator = "uniform";
  const GameSetup& setup = record.setup;
  State state = GenerateStart(setup.settings, setup.start, BoardRng(setup));
  std::array<RuleBasedSeat, kAgentCount> rule_based;
  std::array<Rng, kAgentCount> rngs;
  for (AgentId seat = 0; seat < kAgentCount; ++seat) {
    if (setup.seats[seat].searches) {
      record.tracks[seat].weights_version = weights_version;
      rngs[seat] = SearchRng(setup, seat);
    } else {
      rule_based[seat] = RuleBasedSeat(setup, seat);
    }
  }
  while (!record.outcome.done && !EndsEarly(setup, state)) {
    JointAction actions{};
    for (AgentId seat = 0; seat < kAgentCount; ++seat) {
      if (!state.agents[seat].alive) continue;
      actions[seat] = setup.seats[seat].searches ? DecideAtRandom(state, seat, rngs[seat], record)
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

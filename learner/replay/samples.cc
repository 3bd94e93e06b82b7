#include "learner/replay/samples.h"

#include <algorithm>

#include "common/base/check.h"

namespace powderkeg {
namespace {

struct Replay {
  const GameRecord& game;
  DataSet& data_set;
};

void AddPosition(void* context, const State& state, const Decision& decision, Action action) {
  const auto& [game, data_set] = *static_cast<Replay*>(context);
  Sample& sample = data_set.samples.emplace_back(
      state, decision.visits, decision.agent,
      static_cast<std::int8_t>(OutcomeFor(game, static_cast<AgentId>(decision.agent))),
      static_cast<std::uint16_t>(game.actions.size()), decision.value);
  sample.state.RemoveItems(state.HiddenItems());
  ++data_set.summary.actions[static_cast<std::size_t>(action)];
}

void AddResults(const GameRecord& game, MatchScore& score) {
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    if (!game.setup.seats[static_cast<std::size_t>(agent)].searches) continue;
    const int outcome = OutcomeFor(game, agent);
    score.wins += outcome > 0 ? 1 : 0;
    score.ties += outcome == 0 ? 1 : 0;
    score.losses += outcome < 0 ? 1 : 0;
  }
}

}  // namespace

void AddGame(const GameRecord& game, DataSet& data_set) {
  Replay replay{game, data_set};
  if (const auto reason = Verify(game, AddPosition, &replay)) {
    throw Error(StrCat("stored game of ticket ", game.ticket, " does not verify: ", *reason));
  }
  PlaySummary& summary = data_set.summary;
  summary.games += 1;
  summary.decisions += game.decisions.size();
  summary.steps += game.actions.size();
  summary.weights_versions += std::max(game.weights_version, 1U);
  AddResults(game, summary.score);
}

}  // namespace powderkeg

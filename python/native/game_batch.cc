#include "python/native/game_batch.h"

#include <algorithm>

#include "common/base/check.h"
#include "common/pommerman/generate.h"
#include "common/pommerman/step.h"

namespace powderkeg {
namespace {

GameSetup SetupOf(const GameBatchSettings& settings) {
  GameSetup setup;
  setup.settings = settings.game;
  setup.to_the_end = settings.to_the_end;
  for (AgentId agent = 0; agent < SeatCount(settings.game.mode); ++agent) {
    const std::optional<PolicyKind> policy = settings.policies[agent];
    setup.seats[agent] = {
        .searches = !policy, .policy = policy.value_or(PolicyKind::kIdle), .measured = !policy};
  }
  return setup;
}

}  // namespace

GameBatch::GameBatch(const GameBatchSettings& settings, std::size_t size, std::uint64_t seed)
    : settings_(settings), setup_(SetupOf(settings)), games_(size) {
  Reset(seed);
}

void GameBatch::Reset(std::optional<std::uint64_t> seed) {
  for (std::size_t i = 0; i < games_.size(); ++i) {
    if (seed) games_[i].seeds = Rng(*seed).Split(i);
    Begin(games_[i]);
  }
}

void GameBatch::Begin(Game& game) {
  setup_.seed = game.seeds.Next();
  game.state = GenerateStart(setup_.settings, setup_.start, BoardRng(setup_));
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    if (!setup_.seats[agent].searches) game.seats[agent] = RuleBasedSeat(setup_, agent);
  }
  game.actions = {};
  game.over = false;
}

void GameBatch::Step(std::span<const JointAction> actions,
                     std::span<const std::array<Message, kAgentCount>> messages,
                     const StepResults& results) {
  CHECK(actions.size() == size() && (messages.empty() || messages.size() == size()));
  for (std::size_t i = 0; i < games_.size(); ++i) {
    Game& game = games_[i];
    Outcome outcome{.done = true};
    if (!game.over) {
      outcome = StepGame(game, actions[i],
                         messages.empty() ? std::array<Message, kAgentCount>{} : messages[i]);
    }
    std::ranges::copy(outcome.rewards, results.rewards.begin() + i * kAgentCount);
    results.done[i] = outcome.done;
    results.winners[i] = outcome.winners;
    results.steps[i] = game.state.step;
    game.over = outcome.done;
    if (game.over && settings_.restart) Begin(game);
  }
}

Outcome GameBatch::StepGame(Game& game, const JointAction& actions,
                            const std::array<Message, kAgentCount>& messages) {
  State& state = game.state;
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    if (!state.agents[agent].alive) {
      game.actions[agent] = Action::kStop;
    } else if (setup_.seats[agent].searches) {
      game.actions[agent] = actions[agent];
    } else {
      game.actions[agent] = game.seats[agent].Decide(setup_.settings, state);
    }
  }
  Collapse(setup_.settings, state);
  powderkeg::Step(setup_.settings, game.actions, messages, state);
  Outcome outcome = OutcomeOf(setup_.settings, state);
  outcome.done = outcome.done || EndsEarly(setup_, state);
  return outcome;
}

}  // namespace powderkeg

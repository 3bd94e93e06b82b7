#include "tests/bench/bench_step.h"

#include <string>
#include <utility>

#include "common/base/check.h"
#include "common/policies/policy.h"
#include "common/pommerman/generate.h"
#include "common/pommerman/observation.h"
#include "common/pommerman/step.h"
#include "tests/bench/cpu_time.h"

namespace powderkeg {
namespace {

constexpr int kGames = 200;
constexpr double kSecondsPerFigure = 0.5;

// Repeats `work`, which returns how much it did, and gives the rate after a first, untimed call.
template <typename Work>
double Rate(Work&& work) {
  (void)work();
  const double start = ThreadCpuSeconds();
  long done = 0;
  double seconds = 0;
  while (seconds < kSecondsPerFigure) {
    done += work();
    seconds = ThreadCpuSeconds() - start;
  }
  return static_cast<double>(done) / seconds;
}

struct Game {
  State start;
  State end;
  std::vector<JointAction> actions;
};

Game PlaySimpleUnbiased(const GameSettings& settings, std::uint64_t seed) {
  Rng rng(seed);
  Game game;
  game.start = GenerateStart(settings, StartSettings{}, rng.Split(0));
  std::array<PolicyTraits, kAgentCount> traits;
  std::array<PolicyMemory, kAgentCount> memories{};
  for (PolicyTraits& drawn : traits) drawn = PolicyTraits::Draw(rng);
  State state = game.start;
  for (bool done = false; !done;) {
    JointAction actions{};
    for (AgentId id = 0; id < kAgentCount; ++id) {
      if (!state.agents[id].alive) continue;
      const PolicyView view = {.state = state, .settings = settings, .self = id};
      actions[id] = Decide(PolicyKind::kSimpleUnbiased, view, traits[id], memories[id], rng);
    }
    game.actions.push_back(actions);
    done = Advance(settings, actions, state).done;
  }
  game.end = state;
  return game;
}

// Replays all games by `advance`, which must lead to their ends.
template <typename Advance>
double ReplayRate(const std::vector<Game>& games, Advance&& advance) {
  return Rate([&] {
    long steps = 0;
    for (const Game& game : games) {
      State state = game.start;
      for (const JointAction& actions : game.actions) advance(actions, state);
      CHECK(state == game.end);
      steps += static_cast<long>(game.actions.size());
    }
    return steps;
  });
}

std::vector<State> PositionsOf(const GameSettings& settings, const std::vector<Game>& games) {
  std::vector<State> positions;
  for (std::size_t i = 0; i < games.size(); i += 20) {
    State state = games[i].start;
    for (const JointAction& actions : games[i].actions) {
      positions.push_back(state);
      Step(settings, actions, state);
    }
  }
  return positions;
}

// Calls `look` for every living agent of every position. Its results are added up, so that the
// compiler cannot leave the work out.
template <typename Look>
double LookRate(const std::vector<State>& positions, Look&& look) {
  volatile unsigned seen = 0;
  return Rate([&] {
    long count = 0;
    for (const State& state : positions) {
      for (AgentId id = 0; id < kAgentCount; ++id) {
        if (!state.agents[id].alive) continue;
        seen = seen + look(state, id);
        ++count;
      }
    }
    return count;
  });
}

}  // namespace

std::vector<BenchFigure> BenchStep() {
  const GameSettings settings;
  std::vector<Game> games;
  for (std::uint64_t seed = 0; seed < kGames; ++seed) {
    games.push_back(PlaySimpleUnbiased(settings, seed));
  }
  const std::vector<State> positions = PositionsOf(settings, games);
  const auto step = [&](const JointAction& actions, State& state) {
    Step(settings, actions, state);
  };
  const auto advance = [&](const JointAction& actions, State& state) {
    CHECK(Advance(settings, actions, state).rewards.size() == kAgentCount);
  };
  const auto legal = [](const State& state, AgentId id) -> unsigned {
    return LegalActions(state, id);
  };
  const auto observe = [&](const State& state, AgentId id) -> unsigned {
    return Observe(settings, state, id).flame_life[60];
  };
  std::uint64_t seed = 0;
  const auto generate = [&] {
    return GenerateStart(settings, StartSettings{}, Rng(seed++)).AgentCells().Count() / kAgentCount;
  };
  return {{"step.step", ReplayRate(games, step), "steps/s"},
          {"step.step_and_outcome", ReplayRate(games, advance), "steps/s"},
          {"step.legal_actions", LookRate(positions, legal), "calls/s"},
          {"step.observe", LookRate(positions, observe), "observations/s"},
          {"step.generate", Rate(generate), "boards/s"}};
}

}  // namespace powderkeg

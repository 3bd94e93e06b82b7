#include "tests/bench/bench_policies.h"

#include <functional>

#include "common/base/check.h"
#include "common/record/game_record.h"
#include "common/record/rule_based_seat.h"
#include "tests/bench/cpu_time.h"

namespace powderkeg {

namespace {

constexpr double kSecondsPerFigure = 0.5;

// How many units of work per CPU second `work` does, called with 0, 1, 2 and so on.
double Rate(const std::function<long(std::uint64_t)>& work) {
  (void)work(0);
  const double start = ThreadCpuSeconds();
  long done = 0;
  double seconds = 0;
  for (std::uint64_t call = 1; seconds < kSecondsPerFigure; ++call) {
    done += work(call);
    seconds = ThreadCpuSeconds() - start;
  }
  return static_cast<double>(done) / seconds;
}

GameSetup SetupFor(PolicyKind policy, std::uint64_t seed) {
  GameSetup setup;
  setup.seats.fill({.searches = false, .policy = policy});
  setup.seed = seed;
  return setup;
}

// Plays a whole game; visit(state, actions) sees every step before it is made. Returns the steps.
template <typename Visit>
long PlayGame(const GameSetup& setup, Outcome& outcome, Visit&& visit) {
  State state = GenerateStart(setup.settings, setup.start, BoardRng(setup));
  std::array<RuleBasedSeat, kAgentCount> seats;
  for (AgentId id = 0; id < kAgentCount; ++id) seats[id] = RuleBasedSeat(setup, id);
  for (outcome = Outcome(); !outcome.done;) {
    JointAction actions{};
    for (AgentId id = 0; id < kAgentCount; ++id) {
      if (state.agents[id].alive) actions[id] = seats[id].Decide(setup.settings, state);
    }
    visit(state, actions);
    outcome = Advance(setup.settings, actions, state);
  }
  return state.step;
}

BenchFigure BenchGames(PolicyKind policy) {
  const auto play = [policy](std::uint64_t seed) {
    Outcome outcome;
    return PlayGame(SetupFor(policy, seed), outcome, [](const State&, const JointAction&) {});
  };
  return {StrCat("games.", NameOf(policy)), Rate(play), "steps/s"};
}

// Positions of games of four SimpleUnbiased.
std::vector<State> SamplePositions() {
  std::vector<State> states;
  Outcome outcome;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    PlayGame(SetupFor(PolicyKind::kSimpleUnbiased, seed), outcome,
             [&](const State& state, const JointAction&) { states.push_back(state); });
  }
  return states;
}

BenchFigure BenchDecide(PolicyKind policy, const std::vector<State>& states) {
  const GameSettings settings;
  Rng rng(1);
  std::array<PolicyMemory, kAgentCount> memories{};
  const auto decide = [&](std::uint64_t) {
    const PolicyTraits traits = PolicyTraits::Draw(rng);
    long decisions = 0;
    for (const State& state : states) {
      for (AgentId id = 0; id < kAgentCount; ++id) {
        if (!state.agents[id].alive) continue;
        (void)Decide(policy, {state, settings, id}, traits, memories[id], rng);
        ++decisions;
      }
    }
    return decisions;
  };
  return {StrCat("decide.", NameOf(policy)), Rate(decide), "decisions/s"};
}

// A record in which seat 0 claims to have searched every move of a SimpleUnbiased.
GameRecord RecordOf(std::uint64_t seed) {
  GameRecord record;
  record.setup = SetupFor(PolicyKind::kSimpleUnbiased, seed);
  PlayGame(record.setup, record.outcome, [&](const State& state, const JointAction& actions) {
    record.actions.push_back(actions);
    if (!state.agents[0].alive) return;
    record.tracks[0].decisions.push_back({.step = state.step, .visits = {1}});
  });
  record.setup.seats[0] = {.searches = true, .teaches = Teaches::kSearch, .measured = true};
  return record;
}

BenchFigure BenchVerify() {
  std::vector<GameRecord> records;
  for (std::uint64_t seed = 0; seed < 50; ++seed) records.push_back(RecordOf(seed));
  const auto verify = [&](std::uint64_t call) {
    const GameRecord& record = records[call % records.size()];
    const auto refusal = Verify(record);
    CHECK(!refusal, *refusal);
    return static_cast<long>(DecisionCount(record));
  };
  return {"verify.simple_unbiased", Rate(verify), "decisions/s"};
}

}  // namespace

std::vector<BenchFigure> BenchPolicies() {
  const std::vector<State> states = SamplePositions();
  std::vector<BenchFigure> figures;
  for (const PolicyKind policy : {PolicyKind::kSimpleUnbiased, PolicyKind::kOfficialSimple}) {
    figures.push_back(BenchGames(policy));
    figures.push_back(BenchDecide(policy, states));
  }
  figures.push_back(BenchVerify());
  return figures;
}

}  // namespace powderkeg

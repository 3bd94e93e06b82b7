#include "tests/bench/bench_policies.h"

#include <ctime>
#include <functional>

#include "common/base/check.h"
#include "common/record/game_record.h"
#include "common/record/rule_based_seat.h"

namespace powderkeg {

namespace {

double CpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

constexpr double kSecondsPerFigure = 0.5;

// How many units of work per CPU second `work` does, called with 0, 1, 2 and so on.
double Rate(const std::function<long(std::uint64_t)>& work) {
  (void)work(0);
  const double start = CpuSeconds();
  long done = 0;
  double seconds = 0;
  for (std::uint64_t call = 1; seconds < kSecondsPerFigure; ++call) {
    done += work(call);
    seconds = CpuSeconds() - start;
  }
  return static_cast<double>(done) / seconds;
}

GameSetup SetupFor(PolicyKind policy, std::uint64_t seed) {
  GameSetup setup;
  setup.seats.fill({.searches = false, .policy = policy});
  setup.seed = seed;
  return setup;
}

// Plays a whole game; `visit` sees every position before its step.
template <typename Visit>
long PlayGame(const GameSetup& setup, Visit&& visit) {
  State state = GenerateStart(setup.settings, setup.start, BoardRng(setup));
  std::array<RuleBasedSeat, kAgentCount> seats;
  for (AgentId id = 0; id < kAgentCount; ++id) seats[id] = RuleBasedSeat(setup, id);
  for (Outcome outcome; !outcome.done;) {
    visit(state);
    JointAction actions{};
    for (AgentId id = 0; id < kAgentCount; ++id) {
      if (state.agents[id].alive) actions[id] = seats[id].Decide(setup.settings, state);
    }
    visit(state, actions);
    outcome = Advance(setup.settings, actions, state);
  }
  return state.step;
}

struct VisitNothing {
  void operator()(const State& /*state*/) const {}
  void operator()(const State& /*state*/, const JointAction& /*actions*/) const {}
};

BenchFigure BenchGames(PolicyKind policy) {
  const auto play = [policy](std::uint64_t seed) {
    return PlayGame(SetupFor(policy, seed), VisitNothing());
  };
  return {StrCat("games.", NameOf(policy)), Rate(play), "steps/s"};
}

// Positions of games of four SimpleUnbiased.
std::vector<State> SamplePositions() {
  struct Collect {
    std::vector<State>& states;
    void operator()(const State& state) const { states.push_back(state); }
    void operator()(const State& /*state*/, const JointAction& /*actions*/) const {}
  };
  std::vector<State> states;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    PlayGame(SetupFor(PolicyKind::kSimpleUnbiased, seed), Collect{states});
  }
  return states;
}

BenchFigure BenchDecide(PolicyKind policy, const std::vector<State>& states) {
  const GameSettings settings;
  Rng rng(1);
  PolicyTraits traits;
  std::array<PolicyMemory, kAgentCount> memories{};
  const auto decide = [&](std::uint64_t seed) {
    traits = PolicyTraits::Draw(rng);
    long decisions = 0;
    for (const State& state : states) {
      for (AgentId id = 0; id < kAgentCount; ++id) {
        if (!state.agents[id].alive) continue;
        const Action action = Decide(policy, {state, settings, id}, traits, memories[id], rng);
        decisions += static_cast<int>(action) < kActionCount ? 1 : static_cast<long>(seed);
      }
    }
    return decisions;
  };
  return {StrCat("decide.", NameOf(policy)), Rate(decide), "decisions/s"};
}

// A record in which seat 0 claims to have searched every move of a SimpleUnbiased.
GameRecord RecordOf(std::uint64_t seed) {
  struct Collect {
    GameRecord& record;
    void operator()(const State& state) const {
      if (!state.agents[0].alive) return;
      record.decisions.push_back({.step = state.step, .agent = 0, .visits = {1}});
    }
    void operator()(const State& /*state*/, const JointAction& actions) const {
      record.actions.push_back(actions);
    }
  };
  GameRecord record;
  record.setup = SetupFor(PolicyKind::kSimpleUnbiased, seed);
  State state;
  PlayGame(record.setup, Collect{record});
  record.setup.seats[0].searches = true;
  state = GenerateStart(record.setup.settings, record.setup.start, BoardRng(record.setup));
  for (const JointAction& actions : record.actions) {
    record.outcome = Advance(record.setup.settings, actions, state);
  }
  return record;
}

BenchFigure BenchVerify() {
  std::vector<GameRecord> records;
  for (std::uint64_t seed = 0; seed < 50; ++seed) records.push_back(RecordOf(seed));
  const auto verify = [&](std::uint64_t call) {
    const GameRecord& record = records[call % records.size()];
    const auto refusal = Verify(record);
    CHECK(!refusal, *refusal);
    return static_cast<long>(record.decisions.size());
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

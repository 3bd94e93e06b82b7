#include "tests/bench/bench_clock.h"

#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include "actors/http/agent_service.h"
#include "actors/play/factory.h"
#include "actors/play/parallel_evaluator.h"
#include "actors/runner/runner_json.h"
#include "common/base/check.h"
#include "common/base/log.h"
#include "common/model/evaluation_cache.h"
#include "common/model/model_name.h"
#include "common/onednn/onednn_evaluator.h"
#include "common/pommerman/observation.h"
#include "common/record/rule_based_seat.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;

constexpr int kGames = 3;
constexpr int kStepsBetween = 25;
constexpr int kLastStep = 100;
constexpr int kLeavesPerThread = 4;  // as agent_server has it
constexpr std::size_t kCacheBytes = 16U << 20;

// Requests for agent 0's action every kStepsBetween steps of games among SimpleUnbiased agents.
std::vector<std::string> Requests() {
  std::vector<std::string> requests;
  for (std::uint64_t seed = 1; seed <= kGames; ++seed) {
    GameSetup setup;
    setup.seed = seed;
    setup.seats.fill({.searches = false, .policy = PolicyKind::kSimpleUnbiased});
    std::array<RuleBasedSeat, kAgentCount> seats;
    for (AgentId id = 0; id < kAgentCount; ++id) seats[id] = RuleBasedSeat(setup, id);
    State state = GenerateStart(setup.settings, setup.start, BoardRng(setup));
    while (state.agents[0].alive && state.step <= kLastStep) {
      if (state.step % kStepsBetween == 0) {
        requests.push_back(ActionBody(setup.settings, Observe(setup.settings, state, 0)));
      }
      JointAction actions{};
      for (AgentId id = 0; id < kAgentCount; ++id) {
        if (state.agents[id].alive) actions[id] = seats[id].Decide(setup.settings, state);
      }
      Step(setup.settings, actions, state);
    }
  }
  return requests;
}

std::unique_ptr<Evaluator> MakeEvaluators(const Snapshot& snapshot, Precision precision,
                                          int threads) {
  std::vector<std::unique_ptr<Evaluator>> evaluators;
  for (int i = 0; i < threads; ++i) {
    evaluators.push_back(MakeOnednnEvaluator(snapshot, precision));
  }
  return std::make_unique<ParallelEvaluator>(std::move(evaluators));
}

// The figures, named after `setting`, of one time and number of threads.
std::vector<BenchFigure> Measure(const std::string& setting,
                                 const std::vector<std::string>& requests, milliseconds time,
                                 std::shared_ptr<EvaluationCache> cache, int threads) {
  const int leaves = kLeavesPerThread * threads;
  AgentService service(
      MakeAgent(ParseAgent(StrCat("search:simulations=20000,leaves_per_batch=", leaves))), cache,
      {.move_time = time});
  service.WarmUp();
  (void)service.InitAgent(InitBody(0, Mode::kFreeForAll));
  const std::uint64_t hits_before = cache->hits();
  const std::uint64_t misses_before = cache->misses();
  for (const std::string& request : requests) {
    CHECK(service.Act(request).status == 200);
  }
  const auto hits = static_cast<double>(cache->hits() - hits_before);
  const auto misses = static_cast<double>(cache->misses() - misses_before);
  const ServiceStatistics served = service.statistics();
  const auto searches = static_cast<double>(served.searches);
  const std::string name = StrCat(setting, ".", time.count(), "_ms.threads_", threads, ".");
  return {{name + "simulations", static_cast<double>(served.simulations) / searches, "a move"},
          {name + "evaluations", misses / searches, "a move"},
          {name + "from_memory", 100 * hits / (hits + misses), "% of questions"},
          {name + "slowest_move", static_cast<double>(served.slowest_move.total().count()) / 1000,
           "ms"}};
}

}  // namespace

std::vector<BenchFigure> BenchClock() {
  const std::vector<std::string> requests = Requests();
  log::Init(/*file=*/"", log::Level::kWarn);
  const Snapshot snapshot = LoadModel("untrained:paper");
  std::vector<BenchFigure> figures;
  for (const Precision precision : {Precision::kBf16, Precision::kInt8}) {
    for (const int threads : {1, 2}) {
      const auto cache = std::make_shared<EvaluationCache>(
          MakeEvaluators(snapshot, precision, threads), kCacheBytes);
      for (const int time_ms : {100, 80}) {
        cache->Clear();
        const auto measured = Measure(std::string(NameOf(precision)), requests,
                                      milliseconds(time_ms), cache, threads);
        figures.insert(figures.end(), measured.begin(), measured.end());
      }
    }
  }
  return figures;
}

}  // namespace powderkeg

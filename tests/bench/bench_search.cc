#include "tests/bench/bench_search.h"

#include <ctime>
#include <span>

#include "actors/search/search.h"
#include "actors/search/tree.h"
#include "common/pommerman/step.h"
#include "tests/search/search_support.h"

namespace powderkeg {
namespace {

constexpr int kGames = 4;
constexpr int kMoves = 40;

double CpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// Calls visit(position, models) along the games that agent 0's best moves and everybody's models
// play.
template <typename Visit>
void PlayGames(const SearchSettings& settings, Visit&& visit) {
  for (std::uint64_t seed = 0; seed < kGames; ++seed) {
    State state = KnownStart(seed);
    OpponentModels models = ModelsAtStart(settings, 0, {}, seed);
    for (int move = 0; move < kMoves && state.agents[0].alive; ++move) {
      const SearchResult result = visit(state, models);
      JointAction actions = result.expected_actions;
      actions[0] = result.best;
      const State before = state;
      Advance({}, actions, state);
      models.ObserveStep(before, state);
    }
  }
}

double SimulationsPerSecond(int simulations) {
  SearchSettings settings;
  settings.simulations = simulations;
  settings.opponents.fill(OpponentModel::kSimpleUnbiased);
  settings.tree_reuse = false;
  Search search(settings, {});
  UniformEvaluator evaluator;
  double seconds = 0;
  double all = 0;
  PlayGames(settings, [&](const State& state, const OpponentModels& models) {
    const double start = CpuSeconds();
    search.Start(state, models, Rng(1));
    const SearchResult result = Finish(search, evaluator);
    seconds += CpuSeconds() - start;
    all += result.simulations;
    return result;
  });
  return all / seconds;
}

std::vector<State> SamplePositions() {
  std::vector<State> positions;
  PlayGames({}, [&](const State& state, const OpponentModels& models) {
    positions.push_back(state);
    Search search(SearchSettings{}, {});
    UniformEvaluator evaluator;
    search.Start(state, models, Rng(1));
    return Finish(search, evaluator);
  });
  return positions;
}

// Mean nanoseconds of work(position) over many rounds; the sum of its results is kept alive.
template <typename Work>
double NanosecondsPer(std::span<const State> positions, Work&& work) {
  constexpr int kRounds = 400;
  volatile std::uint64_t sink = 0;
  const double start = CpuSeconds();
  for (int round = 0; round < kRounds; ++round) {
    for (const State& position : positions) sink = sink + work(position);
  }
  const auto calls = static_cast<double>(positions.size()) * kRounds;
  return 1e9 * (CpuSeconds() - start) / calls;
}

double NanosecondsToStep(std::span<const State> positions) {
  return NanosecondsPer(positions, [](State state) {
    Advance({}, {Action::kBomb, Action::kUp, Action::kLeft, Action::kDown}, state);
    return static_cast<std::uint64_t>(state.step);
  });
}

// All other agents' decisions in one position.
double NanosecondsForOpponents(std::span<const State> positions) {
  Rng rng(1);
  const PolicyTraits traits = PolicyTraits::Draw(rng);
  const GameSettings game;
  return NanosecondsPer(positions, [&](const State& state) {
    std::uint64_t sum = 0;
    for (AgentId agent = 1; agent < kAgentCount; ++agent) {
      if (!state.agents[static_cast<std::size_t>(agent)].alive) continue;
      PolicyMemory memory;
      sum += static_cast<std::uint64_t>(
          Decide(PolicyKind::kSimpleUnbiased, {state, game, agent}, traits, memory, rng));
    }
    return sum;
  });
}

// A chain of nodes as deep as typical simulations go: selecting down and backing up once.
double NanosecondsToSelectAndBackUp(std::span<const State> positions) {
  constexpr int kDepth = 6;
  Tree tree(SearchSettings{});
  tree.Clear(1'000'000);
  constexpr std::array<float, kActionCount> kPolicy = {0.2F, 0.2F, 0.2F, 0.2F, 0.1F, 0.1F};
  for (int depth = 0; depth <= kDepth; ++depth) {
    Node& node = tree[tree.Add(depth - 1, Action::kStop)];
    node.side = 1;
    tree.SetEdges(node, /*legal=*/0b111111, kPolicy);
  }
  return NanosecondsPer(positions, [&](const State&) {
    std::uint64_t sum = 0;
    for (NodeIndex node = 0; node < kDepth; ++node) {
      sum += static_cast<std::uint64_t>(tree.Select(tree[node]));
      tree.Visit(node, Action::kStop);
    }
    tree.BackUp(kDepth, 0.5F);
    return sum;
  });
}

double NanosecondsForEdges(std::span<const State> positions) {
  Tree tree(SearchSettings{});
  tree.Clear(1);
  Node& node = tree[tree.Add(kNoNode, Action::kStop)];
  node.side = 1;
  constexpr std::array<float, kActionCount> kPolicy = {0.2F, 0.2F, 0.2F, 0.2F, 0.1F, 0.1F};
  return NanosecondsPer(positions, [&](const State& state) {
    tree.SetEdges(node, LegalActions(state, 0), kPolicy);
    return static_cast<std::uint64_t>(node.legal);
  });
}

}  // namespace

std::vector<BenchFigure> BenchSearch() {
  const std::vector<State> positions = SamplePositions();
  return {
      {"search.simulations_per_s.250", SimulationsPerSecond(250), "simulations/s"},
      {"search.simulations_per_s.1000", SimulationsPerSecond(1000), "simulations/s"},
      {"search.part.step", NanosecondsToStep(positions), "ns"},
      {"search.part.opponents", NanosecondsForOpponents(positions), "ns"},
      {"search.part.edges", NanosecondsForEdges(positions), "ns"},
      {"search.part.select_and_back_up", NanosecondsToSelectAndBackUp(positions), "ns"},
      {"search.node_bytes", sizeof(Node), "bytes"},
      {"search.signature_low_32_bits", static_cast<double>(SearchSignature() & 0xFFFFFFFFU), ""},
  };
}

}  // namespace powderkeg

#include "tests/bench/bench_search.h"

#include <algorithm>
#include <span>

#include "actors/search/search.h"
#include "actors/search/tree.h"
#include "common/pommerman/step.h"
#include "tests/bench/cpu_time.h"
#include "tests/search/search_support.h"

namespace powderkeg {
namespace {

constexpr int kGames = 4;
constexpr int kMoves = 40;

// What a search starts from.
struct Sample {
  State position;
  OpponentModels models;
};

// Of the search itself: what survivability adds to it is measured apart.
SearchSettings SettingsFor(TreeKind tree, int simulations) {
  SearchSettings settings = WithoutAids({});
  settings.tree = tree;
  settings.simulations = simulations;
  settings.opponents.fill(OpponentModel::kSimpleUnbiased);
  settings.tree_reuse = false;
  return settings;
}

// The games that agent 0's best moves and everybody's models play, while everybody lives.
std::vector<Sample> PlayGames() {
  const SearchSettings settings = SettingsFor(TreeKind::kOnePlayer, 250);
  Search search(settings, {});
  UniformEvaluator evaluator;
  std::vector<Sample> samples;
  for (std::uint64_t seed = 0; seed < kGames; ++seed) {
    State state = KnownStart(seed);
    OpponentModels models = ModelsAtStart(settings, 0, {}, seed);
    for (int move = 0; move < kMoves && std::ranges::all_of(state.agents, &AgentState::alive);
         ++move) {
      samples.push_back({state, models});
      search.Start(state, models, Rng(1));
      const SearchResult result = Finish(search, evaluator);
      JointAction actions = result.expected_actions;
      actions[0] = result.best;
      const State before = state;
      Advance({}, actions, state);
      models.ObserveStep({before}, {state});
    }
  }
  return samples;
}

double SimulationsPerSecond(std::span<const Sample> samples, TreeKind tree, int simulations) {
  Search search(SettingsFor(tree, simulations), {});
  UniformEvaluator evaluator;
  double all = 0;
  const double start = ThreadCpuSeconds();
  for (const Sample& sample : samples) {
    search.Start(sample.position, sample.models, Rng(1));
    all += Finish(search, evaluator).simulations;
  }
  return all / (ThreadCpuSeconds() - start);
}

// Mean nanoseconds of work(position) over many rounds; the sum of its results is kept alive.
template <typename Work>
double NanosecondsPer(std::span<const State> positions, Work&& work) {
  constexpr int kRounds = 400;
  volatile std::uint64_t sink = 0;
  const double start = ThreadCpuSeconds();
  for (int round = 0; round < kRounds; ++round) {
    for (const State& position : positions) sink = sink + work(position);
  }
  const auto calls = static_cast<double>(positions.size()) * kRounds;
  return 1e9 * (ThreadCpuSeconds() - start) / calls;
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
  Tree tree(WithoutAids({}));
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
  Tree tree(WithoutAids({}));
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
  constexpr TreeKind kOne = TreeKind::kOnePlayer;
  constexpr TreeKind kTwo = TreeKind::kTwoPlayer;
  const std::vector<Sample> samples = PlayGames();
  std::vector<State> positions;
  for (const Sample& sample : samples) positions.push_back(sample.position);
  const auto rate = [&samples](TreeKind tree, int simulations) {
    return SimulationsPerSecond(samples, tree, simulations);
  };
  return {
      {"search.simulations_per_s.250", rate(kOne, 250), "simulations/s"},
      {"search.simulations_per_s.1000", rate(kOne, 1000), "simulations/s"},
      {"search.two_player.simulations_per_s.250", rate(kTwo, 250), "simulations/s"},
      {"search.two_player.simulations_per_s.1000", rate(kTwo, 1000), "simulations/s"},
      {"search.part.step", NanosecondsToStep(positions), "ns"},
      {"search.part.opponents", NanosecondsForOpponents(positions), "ns"},
      {"search.part.edges", NanosecondsForEdges(positions), "ns"},
      {"search.part.select_and_back_up", NanosecondsToSelectAndBackUp(positions), "ns"},
      {"search.node_bytes", sizeof(Node), "bytes"},
      {"search.signature_low_32_bits", static_cast<double>(SearchSignature() & 0xFFFFFFFFU), ""},
  };
}

}  // namespace powderkeg

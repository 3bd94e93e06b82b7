// Speeds of storage and training.

#include <benchmark/benchmark.h>

#include "learner/replay/store.h"
#include "learner/replay/window.h"
#include "learner/train/batch.h"
#include "learner/train/trainer.h"
#include "tests/learner/played_games.h"
#include "tests/learner/record_support.h"

namespace powderkeg {
namespace {

ReplayWindow MakeWindow(int games) {
  DataSet data_set;
  for (const GameRecord& game : PlayGames(0, games)) AddGame(game, data_set);
  ReplayWindow window(1, std::size_t{1} << 30);
  window.Push(std::move(data_set.samples));
  return window;
}

void AppendToStore(benchmark::State& state) {
  std::vector<GameRecord> games;
  for (int i = 0; i < 100; ++i)
    games.push_back(RandomRecord(static_cast<std::uint64_t>(i), 200, 200));
  const TemporaryFolder folder;
  ReplayStore store(folder.path());
  for (auto _ : state) store.Append(games);
  state.SetItemsProcessed(state.iterations() * 100 * 200);
}
BENCHMARK(AppendToStore)->Unit(benchmark::kMillisecond)->UseRealTime()->Name("append, decisions");

void LoadFromStore(benchmark::State& state) {
  std::vector<GameRecord> games;
  for (int i = 0; i < 100; ++i)
    games.push_back(RandomRecord(static_cast<std::uint64_t>(i), 200, 200));
  const TemporaryFolder folder;
  ReplayStore store(folder.path());
  store.Append(games);
  for (auto _ : state)
    store.Load([](std::uint64_t) { return true; },
               [](GameRecord&& game) { benchmark::DoNotOptimize(game); });
  state.SetItemsProcessed(state.iterations() * 100 * 200);
}
BENCHMARK(LoadFromStore)->Unit(benchmark::kMillisecond)->Name("load, decisions");

// A restart of a run whose games were all used long ago.
void RestartFromStore(benchmark::State& state) {
  const TemporaryFolder folder;
  ReplayStore store(folder.path());
  std::uint64_t ticket = 0;
  for (int segment = 0; segment < 100; ++segment) {
    std::vector<GameRecord> games;
    for (int i = 0; i < 10'000; ++i) games.push_back(RandomRecord(ticket++, 2, 2));
    store.Append(games);
  }
  const bool all = state.range(0) != 0;
  for (auto _ : state) {
    store.Load([&](std::uint64_t) { return all; },
               [](GameRecord&& game) { benchmark::DoNotOptimize(game); });
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(ticket));
}
BENCHMARK(RestartFromStore)
    ->Arg(1)
    ->Arg(0)
    ->ArgName("wanted")
    ->Unit(benchmark::kMillisecond)
    ->Name("restart, stored games");

void ReplaySamples(benchmark::State& state) {
  const std::vector<GameRecord> games = PlayGames(0, 20);
  std::int64_t decisions = 0;
  for (auto _ : state) {
    DataSet data_set;
    for (const GameRecord& game : games) AddGame(game, data_set);
    decisions += std::ssize(data_set.samples);
  }
  state.SetItemsProcessed(decisions);
}
BENCHMARK(ReplaySamples)->Unit(benchmark::kMillisecond)->Name("games to samples, decisions");

void BuildBatches(benchmark::State& state) {
  const ReplayWindow window = MakeWindow(20);
  std::vector<const Sample*> samples;
  for (std::size_t i = 0; i < 256; ++i) samples.push_back(&window[i % window.size()]);
  Rng rng(1);
  TrainingBatch batch;
  for (auto _ : state) BuildBatch(GameSettings{}, {.argmax_weight = 0.5}, samples, rng, batch);
  state.SetItemsProcessed(state.iterations() * 256);
}
BENCHMARK(BuildBatches)->Unit(benchmark::kMicrosecond)->Name("batch of 256, samples");

// Arguments: 0 small, 1 paper; precision; threads.
void TrainNetwork(benchmark::State& state) {
  const ReplayWindow window = MakeWindow(20);
  TrainerSettings settings;
  settings.precision = static_cast<Precision>(state.range(1));
  settings.training.threads = static_cast<int>(state.range(2));
  settings.training.epochs =
      4.0 * settings.training.batch_size / static_cast<double>(window.size());
  TrainerState start;
  start.weights = InitialWeights(state.range(0) == 0 ? SmallNetwork() : PaperNetwork(), Rng(1));
  Trainer trainer(settings, start);
  state.SetLabel(trainer.description());
  std::uint64_t samples = trainer.Train(window, /*iteration=*/1, Rng(1), {}, nullptr).samples;
  samples = 0;
  for (auto _ : state)
    samples += trainer.Train(window, /*iteration=*/1, Rng(1), {}, nullptr).samples;
  state.SetItemsProcessed(static_cast<std::int64_t>(samples));
}
BENCHMARK(TrainNetwork)
    ->ArgNames({"paper", "precision", "threads"})
    ->ArgsProduct({{0, 1},
                   {static_cast<long>(Precision::kFp32), static_cast<long>(Precision::kBf16)},
                   {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Name("train, samples");

}  // namespace
}  // namespace powderkeg

BENCHMARK_MAIN();

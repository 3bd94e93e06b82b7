#include "learner/train/learner_loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/check.h"
#include "common/base/worker.h"
#include "learner/replay/store.h"
#include "tests/learner/played_games.h"
#include "tests/learner/record_support.h"

namespace powderkeg {
namespace {

namespace fs = std::filesystem;

constexpr int kDecisions = 100;
constexpr int kGames = 80;  // plenty for four data sets

LearnerLoopSettings SettingsFor(const fs::path& folder, int iterations) {
  LearnerLoopSettings settings;
  settings.training.iterations = iterations;
  settings.training.decisions_per_iteration = kDecisions;
  settings.training.window_datasets = 2;
  settings.training.epochs = 1;
  settings.training.batch_size = 32;
  settings.training.device = "cpu";
  settings.precision = Precision::kFp32;
  settings.folder = folder;
  return settings;
}

// What a run of the loop told.
struct RunLog {
  std::vector<Snapshot> published;
  std::vector<IterationReport> trained;  // told before the checkpoint
  std::vector<IterationReport> reports;

  LearnerLoopHooks Hooks() {
    return {.publish = [this](const Snapshot& snapshot) { published.push_back(snapshot); },
            .iteration_trained =
                [this](const IterationReport& report, std::span<const GameResult> /*results*/) {
                  trained.push_back(report);
                  return StrCat("table of ", report.iteration);
                },
            .iteration_done = [this](const IterationReport& report) { reports.push_back(report); }};
  }
};

RunLog RunLoop(const LearnerLoopSettings& settings, const std::vector<GameRecord>& games) {
  RunLog run;
  LearnerLoop loop(settings, run.Hooks());
  for (const GameRecord& game : games) loop.Add(LessonsOf(game));
  loop.Run({});
  return run;
}

TEST(LearnerLoop, TrainsIterationAfterIteration) {
  const TemporaryFolder folder;
  const RunLog run = RunLoop(SettingsFor(folder.path(), 2), PlayGames(0, kGames));
  ASSERT_EQ(run.reports.size(), 2u);
  EXPECT_EQ(run.reports[1].iteration, 2);
  EXPECT_GE(run.reports[0].decisions, static_cast<std::uint64_t>(kDecisions));
  EXPECT_EQ(run.reports[0].score.games(), run.reports[0].games);
  EXPECT_EQ(run.reports[0].weights_lag, 0);
  EXPECT_EQ(run.reports[1].weights_lag, 1) << "all games were started before the first iteration";
  ASSERT_EQ(run.published.size(), 3u);
  EXPECT_EQ(run.published[0], nullptr) << "nothing to play with before the first iteration";
  EXPECT_EQ(run.published[1]->version, 2u);
  EXPECT_EQ(run.published[2]->version, 3u);
  EXPECT_EQ(run.published[2]->canary.states.size(), 8u);
  EXPECT_THAT(run.trained, testing::ElementsAreArray(run.reports));
  EXPECT_EQ(*LoadSnapshot((folder.path() / "weights" / "version-000003.weights").string()),
            *run.published[2]);
  EXPECT_EQ(LoadSnapshot((folder.path() / "weights" / "version-000001.weights").string())->version,
            1u);
}

TEST(LearnerLoop, TheOrderOfArrivalDoesNotMatter) {
  const TemporaryFolder folder;
  const TemporaryFolder other_folder;
  std::vector<GameRecord> games = PlayGames(0, kGames);
  const RunLog run = RunLoop(SettingsFor(folder.path(), 2), games);
  Rng(7).Shuffle(std::span(games));
  games.push_back(games.front());  // a double
  const RunLog shuffled = RunLoop(SettingsFor(other_folder.path(), 2), games);
  EXPECT_EQ(*run.published.back(), *shuffled.published.back());
}

TEST(LearnerLoop, SequentialIterationsLearnFromTheirOwnWeightsAlone) {
  const TemporaryFolder folder;
  LearnerLoopSettings settings = SettingsFor(folder.path(), 2);
  settings.training.sequential = true;
  // More games without a network than iteration 1 wants, some of them after it has begun.
  std::vector<GameRecord> games = PlayGames(0, kGames);
  RunLog run;
  LearnerLoopHooks hooks = run.Hooks();
  LearnerLoop* loop = nullptr;
  hooks.iteration_done = [&](const IterationReport& report) {
    run.reports.push_back(report);
    for (std::uint64_t ticket = kGames; ticket < 2 * kGames && report.iteration == 1; ++ticket) {
      games.push_back(PlayGame(ticket, /*weights_version=*/ticket % 2 == 0 ? 0 : 2));
      loop->Add(LessonsOf(games.back()));
    }
  };
  LearnerLoop first(settings, hooks);
  loop = &first;
  for (const GameRecord& game : games) first.Add(LessonsOf(game));
  first.Run({});
  ASSERT_EQ(run.reports.size(), 2u);
  EXPECT_EQ(run.reports[0].weights_lag, 0);
  EXPECT_EQ(run.reports[1].weights_lag, 0) << "those played ahead are passed over";
  EXPECT_GE(run.reports[1].decisions, static_cast<std::uint64_t>(kDecisions));

  settings.training.iterations = 3;
  LearnerLoop again(settings, {});
  for (const GameRecord& game : games) again.Add(LessonsOf(game));
  EXPECT_EQ(again.progress().iteration, 2) << "and after a restart";
  EXPECT_EQ(again.progress().games.decisions_in_prefix, 0u);
}

TEST(LearnerLoop, AContinuousIterationTakesAllGamesAndTrainsNoMoreThanUsual) {
  const TemporaryFolder folder;
  LearnerLoopSettings settings = SettingsFor(folder.path(), 1);
  const RunLog usual = RunLoop(settings, PlayGames(0, kGames));
  const TemporaryFolder other_folder;
  settings.folder = other_folder.path();
  settings.training.continuous = true;
  settings.training.window_datasets = 1;
  const RunLog run = RunLoop(settings, PlayGames(0, kGames));
  ASSERT_EQ(run.reports.size(), 1u);
  EXPECT_EQ(run.reports[0].games, static_cast<std::uint64_t>(kGames));
  ASSERT_GT(run.reports[0].decisions, usual.reports[0].decisions);
  const auto wanted = settings.training.epochs * kDecisions;
  EXPECT_NEAR(run.reports[0].reuse_ratio * static_cast<double>(run.reports[0].decisions), wanted,
              settings.training.batch_size);
}

TEST(LearnerLoop, ARestartGoesOnExactlyWhereItWas) {
  const std::vector<GameRecord> games = PlayGames(0, kGames);
  const TemporaryFolder folder;
  const RunLog uninterrupted = RunLoop(SettingsFor(folder.path(), 4), games);

  const TemporaryFolder other_folder;
  RunLoop(SettingsFor(other_folder.path(), 1), games);
  RunLoop(SettingsFor(other_folder.path(), 3), games);
  const RunLog last = RunLoop(SettingsFor(other_folder.path(), 4), games);
  EXPECT_EQ(LearnerLoop(SettingsFor(other_folder.path(), 4), {}).table(), "table of 4");
  ASSERT_EQ(last.published.size(), 2u) << "the weights of the checkpoint, then of iteration 4";
  EXPECT_EQ(last.published[0]->version, 4u);
  EXPECT_EQ(last.published[0]->arrays, uninterrupted.published[3]->arrays);
  EXPECT_EQ(*last.published[1], *uninterrupted.published[4]);
  ASSERT_EQ(last.reports.size(), 1u);
  EXPECT_EQ(last.reports[0].decisions, uninterrupted.reports[3].decisions);
}

// Two demonstrations are the first data set, though they hold less than it takes; what follows is
// played when they are learned. A restart is given both again.
TEST(LearnerLoop, DemonstrationsAreTheFirstDataSet) {
  std::vector<GameRecord> games = PlayGames(0, kGames);
  const auto run_loop = [&](const fs::path& folder, int iterations, std::uint64_t wanted_after) {
    LearnerLoopSettings settings = SettingsFor(folder, iterations);
    settings.training.decisions_per_iteration = 1000;
    RunLog run;
    LearnerLoop loop(settings, run.Hooks());
    EXPECT_TRUE(loop.Wants(0));
    loop.AddDemonstrations({LessonsOf(games[0]), LessonsOf(games[1])});
    EXPECT_EQ(loop.next_ticket(), 2u);
    EXPECT_EQ(loop.GamesWanted(), wanted_after);
    for (std::size_t i = 2; i < games.size(); ++i) loop.Add(LessonsOf(games[i]));
    loop.Run({});
    return run;
  };
  const TemporaryFolder folder, other_folder;
  const RunLog whole = run_loop(folder.path(), 2, 0);
  ASSERT_EQ(whole.reports.size(), 2u);
  EXPECT_EQ(whole.reports[0].games, 2u);
  EXPECT_LT(whole.reports[0].decisions, 1000u);
  EXPECT_GE(whole.reports[1].decisions, 1000u);
  run_loop(other_folder.path(), 1, 0);
  const RunLog resumed = run_loop(other_folder.path(), 2, /*of a usual length*/ 5);
  EXPECT_EQ(*resumed.published.back(), *whole.published.back());
}

TEST(LearnerLoop, SomeDemonstrationsMustNotBeHeldOut) {
  const TemporaryFolder folder;
  LearnerLoopSettings settings = SettingsFor(folder.path(), 1);
  settings.training.held_out_share = 1;
  LearnerLoop loop(settings, {});
  EXPECT_THROW(loop.AddDemonstrations({LessonsOf(PlayGame(0))}), Error);
}

TEST(LearnerLoop, AnIterationStoppedInTrainingIsRepeated) {
  const std::vector<GameRecord> games = PlayGames(0, kGames);
  const TemporaryFolder folder;
  const RunLog uninterrupted = RunLoop(SettingsFor(folder.path(), 2), games);

  const TemporaryFolder other_folder;
  LearnerLoopSettings endless = SettingsFor(other_folder.path(), 2);
  endless.training.epochs = 1e6;
  RunLog stopped;
  {
    LearnerLoop loop(endless, stopped.Hooks());
    for (const GameRecord& game : games) loop.Add(LessonsOf(game));
    Worker trainer("trainer", [&](const std::stop_token& stop) { loop.Run(stop); });
    while (loop.progress().training.samples_done == 0) std::this_thread::yield();
    trainer.RequestStop();
    trainer.Join();
  }
  EXPECT_THAT(stopped.published, testing::ElementsAre(nullptr));
  const RunLog resumed = RunLoop(SettingsFor(other_folder.path(), 2), games);
  EXPECT_EQ(*resumed.published.back(), *uninterrupted.published.back());
}

TEST(LearnerLoop, WaitsForAStragglerAndStopsWhenAsked) {
  const TemporaryFolder folder;
  LearnerLoop loop(SettingsFor(folder.path(), 2), {});
  for (const GameRecord& game : PlayGames(1, kGames)) loop.Add(LessonsOf(game));
  EXPECT_EQ(loop.progress().games.straggler, 0u);
  EXPECT_EQ(loop.progress().games.decisions_in_prefix, 0u);
  EXPECT_EQ(loop.GamesWanted(), 0u);
  Worker trainer("trainer", [&](const std::stop_token& stop) { loop.Run(stop); });
  loop.Add(LessonsOf(PlayGame(0)));
  while (loop.progress().iteration < 2) std::this_thread::yield();
  trainer.Join();
  EXPECT_EQ(loop.GamesWanted(), 0u) << "no iteration is left";

  const TemporaryFolder idle_folder;
  LearnerLoop idle(SettingsFor(idle_folder.path(), 1), {});
  EXPECT_GT(idle.GamesWanted(), 0u);
  Worker waiting("waiting", [&](const std::stop_token& stop) { idle.Run(stop); });
  waiting.RequestStop();
  waiting.Join();
  EXPECT_EQ(idle.progress().iteration, 0);
}

// The run keeps them from its first moment: a restart before the first iteration has them too.
TEST(LearnerLoop, GivenWeightsArePublishedFirst) {
  const TemporaryFolder folder;
  WeightsSnapshot weights = InitialWeights(SmallNetwork(), Rng(5));
  weights.version = 40;
  const std::string file = (folder.path() / "given.weights").string();
  SaveSnapshot(weights, file);
  LearnerLoopSettings settings = SettingsFor(folder.path(), 1);
  settings.first = LoadFirstState(file);
  { const LearnerLoop killed(settings, {}); }
  settings.first.reset();
  const RunLog run = RunLoop(settings, PlayGames(0, kGames));
  ASSERT_EQ(run.published.size(), 2u);
  EXPECT_EQ(run.published[0]->version, 1u);
  EXPECT_EQ(run.published[0]->arrays, weights.arrays);
  EXPECT_EQ(run.published[1]->version, 2u);
}

TEST(LearnerLoop, GivenCheckpointsBringTheirOptimizer) {
  const TemporaryFolder folder;
  RunLoop(SettingsFor(folder.path(), 1), PlayGames(0, kGames));
  const TrainerState first =
      LoadFirstState((folder.path() / "checkpoints/iteration-00000001.checkpoint").string());
  EXPECT_EQ(first.weights.version, 1u);
  EXPECT_GT(first.optimizer_steps, 0u);
  EXPECT_FALSE(first.optimizer.empty());
}

TEST(LearnerLoop, GivenWeightsOfAnotherNetworkAreAnError) {
  const TemporaryFolder folder;
  LearnerLoopSettings settings = SettingsFor(folder.path(), 1);
  settings.first = LoadFirstState("untrained:paper");
  EXPECT_THROW(LearnerLoop(settings, {}), Error);
}

TEST(LearnerLoop, HeldOutGamesAreMeasuredAndNotTrainedOn) {
  const TemporaryFolder folder;
  LearnerLoopSettings settings = SettingsFor(folder.path(), 1);
  settings.training.held_out_share = 0.5;
  const RunLog run = RunLoop(settings, PlayGames(0, kGames));
  ASSERT_EQ(run.reports.size(), 1u);
  EXPECT_GT(run.reports[0].held_out_samples, 0u);
  EXPECT_GT(run.reports[0].held_out_policy_loss, 0);
  EXPECT_NE(run.reports[0].held_out_policy_loss, run.reports[0].policy_loss);
}

// It was lost with a damaged segment.
TEST(LearnerLoop, GoesOnWithoutAGameOfAFinishedIteration) {
  const TemporaryFolder folder;
  std::vector<GameRecord> games = PlayGames(0, kGames);
  RunLoop(SettingsFor(folder.path(), 1), games);
  games.erase(games.begin());
  EXPECT_EQ(RunLoop(SettingsFor(folder.path(), 2), games).reports.size(), 1u);
}

TEST(LearnerLoop, AnotherNetworkThanThatOfTheRunIsAnError) {
  const TemporaryFolder folder;
  RunLoop(SettingsFor(folder.path(), 1), PlayGames(0, kGames));
  LearnerLoopSettings settings = SettingsFor(folder.path(), 2);
  settings.training.network = "paper";
  EXPECT_THROW(LearnerLoop(settings, {}), Error);
}

TEST(LearnerLoop, RestartsFromTheStore) {
  const TemporaryFolder folder;
  const std::vector<GameRecord> games = PlayGames(0, kGames);
  RunLoop(SettingsFor(folder.path(), 1), games);
  ReplayStore store(folder.path() / "replay");
  store.Append(games);
  RunLog run;
  LearnerLoop loop(SettingsFor(folder.path(), 2), run.Hooks());
  store.Load([](std::uint64_t) { return true; },
             [&](const GameRecord& game) { loop.Add(LessonsOf(game)); });
  loop.Run({});
  ASSERT_EQ(run.reports.size(), 1u);
  EXPECT_EQ(run.reports[0].iteration, 2);
}

}  // namespace
}  // namespace powderkeg

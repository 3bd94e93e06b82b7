#include "learner/train/trainer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/base/check.h"
#include "common/torch/torch_evaluator.h"
#include "learner/train/batch.h"
#include "learner/train/checkpoint.h"
#include "tests/learner/played_games.h"
#include "tests/learner/record_support.h"

namespace powderkeg {
namespace {

using testing::HasSubstr;
using testing::Not;

// As small as networks get: tests of the mechanics.
NetworkDescription TinyNetwork() {
  NetworkDescription description;
  description.stem_channels = 4;
  description.blocks = {{BlockDescription::Kind::kInvertedResidual, 8, 4, 1},
                        {BlockDescription::Kind::kInvertedResidual, 8, 4, 2}};
  description.value_channels = 1;
  description.value_hidden = 8;
  description.policy_channels = 4;
  return description;
}

TrainerSettings TinySettings() {
  TrainerSettings settings;
  settings.training.batch_size = 32;
  settings.training.epochs = 1;
  settings.training.device = "cpu";
  settings.precision = Precision::kFp32;
  return settings;
}

TrainerState FreshState() {
  TrainerState state;
  state.weights = InitialWeights(TinyNetwork(), Rng(1));
  return state;
}

ReplayWindow WindowOf(int games) {
  DataSet data_set;
  for (const GameRecord& game : PlayGames(0, games)) AddGame(game, data_set);
  ReplayWindow window(1, std::size_t{1} << 30);
  window.Push(std::move(data_set.samples));
  return window;
}

TrainingResult Train(Trainer& trainer, const ReplayWindow& window, std::uint64_t seed = 1) {
  return trainer.Train(window, /*iteration=*/1, Rng(seed), {}, nullptr);
}

TEST(Trainer, LearnsWhatItIsShown) {
  const ReplayWindow window = WindowOf(10);
  TrainerSettings settings = TinySettings();
  settings.training.epochs = 4;
  settings.training.learning_rate = 0.01;
  Trainer trainer(settings, FreshState());
  const TrainingResult first = Train(trainer, window);
  const TrainingResult second = Train(trainer, window);
  EXPECT_TRUE(first.finished);
  EXPECT_LT(second.total_loss, first.total_loss);
  EXPECT_LT(second.policy_loss, std::log(6.0)) << "better than a guess";
  EXPECT_GT(second.policy_accuracy, 1.0 / 6);
  EXPECT_NEAR(second.total_loss, 0.1 * second.value_loss + 0.9 * second.policy_loss, 1e-9);
}

// A fresh network says nearly 1/6 and 0, so its first losses follow from the targets alone.
TEST(Trainer, TheLossIsThePapers) {
  const ReplayWindow window = WindowOf(4);
  TrainerSettings settings = TinySettings();
  settings.training.batch_size = static_cast<int>(window.size());
  Trainer trainer(settings, FreshState());
  const TrainingResult result = Train(trainer, window);
  double squares = 0;
  for (std::size_t i = 0; i < window.size(); ++i) squares += window[i].outcome * window[i].outcome;
  EXPECT_NEAR(result.policy_loss, std::log(6.0), 0.05);
  double entropy = 0;
  for (std::size_t i = 0; i < window.size(); ++i) {
    for (const float p : PolicyTarget(window[i].visits, settings.training.target_argmax_weight)) {
      if (p > 0) entropy -= p * std::log(p);
    }
  }
  EXPECT_NEAR(result.target_entropy, entropy / static_cast<double>(window.size()), 1e-4);
  EXPECT_NEAR(result.value_loss, squares / static_cast<double>(window.size()), 0.1);
  EXPECT_EQ(result.samples, window.size());
}

// Of fast searches only the value is learned; they do not water the policy's figures down.
TEST(Trainer, SamplesWithoutAPolicyTrainTheValueAlone) {
  DataSet data_set;
  for (const GameRecord& game : PlayGames(0, 4)) AddGame(game, data_set);
  const auto losses = [&](auto&& has_policy) {
    DataSet changed = data_set;
    for (std::size_t i = 0; i < changed.samples.size(); ++i) {
      if (!has_policy(i)) changed.samples[i].visits = {};
    }
    TrainerSettings settings = TinySettings();
    settings.training.batch_size = static_cast<int>(changed.samples.size());
    ReplayWindow window(1, std::size_t{1} << 30);
    window.Push(std::move(changed.samples));
    Trainer trainer(settings, FreshState());
    return Train(trainer, window);
  };
  const TrainingResult half = losses([](std::size_t i) { return i % 2 == 0; });
  EXPECT_NEAR(half.policy_loss, std::log(6.0), 0.05);
  EXPECT_NEAR(half.total_loss, 0.1 * half.value_loss + 0.9 * half.policy_loss / 2, 0.01);
  const TrainingResult none = losses([](std::size_t) { return false; });
  EXPECT_EQ(none.policy_loss, 0);
  EXPECT_EQ(none.policy_accuracy, 0);
  EXPECT_NEAR(none.value_loss, half.value_loss, 0.05);
}

TEST(Trainer, EqualTrainingGivesEqualWeightsBitForBit) {
  const ReplayWindow window = WindowOf(3);
  Trainer first(TinySettings(), FreshState());
  Trainer second(TinySettings(), FreshState());
  Train(first, window);
  Train(second, window);
  EXPECT_EQ(first.state(2), second.state(2));
  Train(second, window);
  EXPECT_NE(first.state(2).weights.arrays, second.state(2).weights.arrays);
}

TEST(Trainer, ResumedTrainingEqualsUninterruptedBitForBit) {
  const ReplayWindow window = WindowOf(3);
  Trainer uninterrupted(TinySettings(), FreshState());
  Train(uninterrupted, window, 1);
  const std::vector<std::uint8_t> bytes = Serialize(Checkpoint{{}, uninterrupted.state(2), {}});
  Train(uninterrupted, window, 2);

  const Checkpoint checkpoint = DeserializeCheckpoint(bytes);
  EXPECT_EQ(checkpoint.trainer.samples_seen, checkpoint.trainer.optimizer_steps * 32);
  Trainer resumed(TinySettings(), checkpoint.trainer);
  EXPECT_EQ(resumed.state(2), checkpoint.trainer);
  Train(resumed, window, 2);
  EXPECT_EQ(resumed.state(3), uninterrupted.state(3));
}

TEST(Trainer, StopsBetweenBatches) {
  const ReplayWindow window = WindowOf(4);
  Trainer trainer(TinySettings(), FreshState());
  std::stop_source stop;
  int batches = 0;
  const TrainingResult result = trainer.Train(
      window, /*iteration=*/1, Rng(1), stop.get_token(), [&](const TrainingProgress& progress) {
        EXPECT_EQ(progress.samples_done, static_cast<std::uint64_t>(32 * ++batches));
        if (batches == 2) stop.request_stop();
      });
  EXPECT_FALSE(result.finished);
  EXPECT_EQ(result.samples, 64u);
}

TEST(Trainer, StopsWithinALargeBatch) {
  const ReplayWindow window = WindowOf(4);
  TrainerSettings settings = TinySettings();
  settings.training.batch_size = 1 << 20;
  const TrainerState before = FreshState();
  Trainer trainer(settings, before);
  std::stop_source stop;
  const TrainingResult result = trainer.Train(window, /*iteration=*/1, Rng(1), stop.get_token(),
                                              [&](const TrainingProgress& progress) {
                                                EXPECT_EQ(progress.samples, 1u << 20);
                                                stop.request_stop();
                                              });
  EXPECT_FALSE(result.finished);
  EXPECT_LT(result.samples, 10'000u);
  EXPECT_EQ(trainer.state(1).optimizer_steps, 0u);
}

TEST(Trainer, ALargeBatchIsOneStep) {
  const ReplayWindow window = WindowOf(4);
  TrainerSettings settings = TinySettings();
  settings.training.batch_size = 2500;
  Trainer trainer(settings, FreshState());
  const TrainingResult result = Train(trainer, window);
  EXPECT_TRUE(result.finished);
  EXPECT_EQ(result.samples, 2500u);
  EXPECT_NEAR(result.policy_loss, std::log(6.0), 0.05);
  EXPECT_EQ(trainer.state(2).optimizer_steps, 1u);
}

TEST(Trainer, WarnsOfALossFarAboveThatOfGuessing) {
  const ReplayWindow window = WindowOf(4);
  TrainerSettings settings = TinySettings();
  const auto warnings = [&](double learning_rate) {
    settings.training.learning_rate = learning_rate;
    Trainer trainer(settings, FreshState());
    testing::internal::CaptureStderr();
    Train(trainer, window);
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_THAT(warnings(0.001), Not(HasSubstr("far above")));
  EXPECT_THAT(warnings(10), HasSubstr("W the loss is far above that of guessing"));
}

TEST(Trainer, EpochsMayBeFractionsAndWindowsSmall) {
  const ReplayWindow window = WindowOf(4);
  TrainerSettings settings = TinySettings();
  settings.training.epochs = 0.5;
  Trainer half(settings, FreshState());
  EXPECT_NEAR(static_cast<double>(Train(half, window).samples),
              static_cast<double>(window.size()) / 2, 32);
  settings.training.batch_size = static_cast<int>(2 * window.size() + 1);
  Trainer large_batch(settings, FreshState());
  EXPECT_EQ(Train(large_batch, window).samples, 2 * window.size() + 1);
}

TEST(Trainer, Bf16LearnsToo) {
  const ReplayWindow window = WindowOf(5);
  TrainerSettings settings = TinySettings();
  settings.precision = Precision::kBf16;
  settings.training.epochs = 2;
  Trainer trainer(settings, FreshState());
  EXPECT_THAT(trainer.description(), testing::HasSubstr("cpu bf16"));
  const TrainingResult first = Train(trainer, window);
  EXPECT_LT(Train(trainer, window).total_loss, first.total_loss);
}

TEST(Trainer, ThePublishedSnapshotCarriesItsCanary) {
  const ReplayWindow window = WindowOf(3);
  Trainer trainer(TinySettings(), FreshState());
  Train(trainer, window);
  const Snapshot snapshot = MakePublishedSnapshot(trainer.state(7), window);
  EXPECT_EQ(snapshot->version, 7u);
  ASSERT_EQ(snapshot->canary.states.size(), 8u);
  const auto evaluator = MakeTorchEvaluator(snapshot, {});
  const CanaryDifference difference = CompareCanary(*snapshot, *evaluator);
  EXPECT_EQ(difference.policy, 0);
  EXPECT_EQ(difference.value, 0);
  EXPECT_EQ(MakePublishedSnapshot(trainer.state(7), ReplayWindow(1, 1))->canary.states.size(), 0u);
}

std::string MessageOf(const TrainerSettings& settings, const TrainerState& state) {
  try {
    Trainer trainer(settings, state);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Trainer, SettingsItCannotFollowAreErrors) {
  TrainerSettings settings = TinySettings();
  settings.training.device = "tpu";
  EXPECT_THAT(MessageOf(settings, FreshState()), testing::HasSubstr("tpu"));
  settings.training.device = "cpu";
  settings.precision = Precision::kFp16;
  EXPECT_THAT(MessageOf(settings, FreshState()), testing::HasSubstr("fp16"));
  if (!IsCudaAvailable()) {
    settings.training.device = "cuda";
    EXPECT_THAT(MessageOf(settings, FreshState()), testing::HasSubstr("no CUDA"));
  }
}

TEST(Trainer, AnOptimizerStateOfAnotherNetworkIsAnError) {
  TrainerState state = FreshState();
  state.optimizer = {{"stem.conv.weight.exp_avg", {1}, {0.0F}}};
  EXPECT_THAT(MessageOf(TinySettings(), state), testing::HasSubstr("optimizer state"));
}

TEST(Trainer, DivergenceIsAnError) {
  const ReplayWindow window = WindowOf(3);
  TrainerSettings settings = TinySettings();
  settings.training.learning_rate = 1e30;
  settings.training.epochs = 3;
  Trainer trainer(settings, FreshState());
  EXPECT_THROW(Train(trainer, window), Error);
}

}  // namespace
}  // namespace powderkeg

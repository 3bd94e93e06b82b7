#include "common/torch/torch_evaluator.h"

#include <gtest/gtest.h>

#include <array>

#include "common/base/check.h"
#include "common/model/planes.h"
#include "common/torch/device_planes.h"
#include "common/torch/snapshot_conversion.h"
#include "tests/model/positions.h"
#include "tests/model/reference_evaluator.h"

namespace powderkeg {
namespace {

// The module's logits of the others as probabilities, where they are marked.
void Foretell(const NetworkOutput& output, const Position& position, Evaluation& evaluation) {
  const torch::Tensor policies = output.others_logits.softmax(2).contiguous();
  for (std::size_t other = 0; other < evaluation.others.size(); ++other) {
    if (MarkedCell(position, static_cast<int>(other) + 1) == kNoCell) continue;
    const float* const policy = policies.data_ptr<float>() + other * kActionCount;
    std::transform(policy, policy + kActionCount, evaluation.others[other].begin(), InWholes);
  }
}

// The module's answers in evaluation mode: batch norm not folded, plain memory format.
std::vector<Evaluation> AnswersOfModule(const Snapshot& snapshot,
                                        const std::vector<Position>& positions) {
  const torch::NoGradGuard no_grad;
  Network network = MakeNetwork(*snapshot);
  network->eval();
  std::vector<Evaluation> evaluations;
  for (const Position& position : positions) {
    std::array<float, kPlanesSize> planes{};
    EncodePlanes(GameSettings{}, position, planes);
    const NetworkOutput output = network(
        torch::from_blob(planes.data(), {1, kPlaneCount, kBoardSize, kBoardSize}, torch::kFloat32));
    const torch::Tensor policy = output.policy_logits.softmax(1).contiguous();
    Evaluation& evaluation = evaluations.emplace_back();
    std::copy_n(policy.data_ptr<float>(), kActionCount, evaluation.policy.begin());
    evaluation.value = output.value.item<float>();
    if (output.others_logits.defined()) Foretell(output, position, evaluation);
  }
  return evaluations;
}

// What a CUDA device computes, here on the CPU.
TEST(DevicePlanes, ExpandToThePlanes) {
  const std::vector<State> states = PlayedStates(20, /*seed=*/3);
  const std::vector<Position> positions = PositionsOf(states);
  const auto count = static_cast<std::int64_t>(positions.size());
  const torch::Tensor counts =
      torch::empty({count, kPlaneCount + 1, kBoardSize, kBoardSize}, torch::kInt8);
  const torch::Tensor planes = torch::empty({count, kPlaneCount, kBoardSize, kBoardSize});
  auto* next_counts = counts.data_ptr<std::int8_t>();
  float* next_planes = planes.data_ptr<float>();
  for (const Position& position : positions) {
    EncodePlaneCounts(position,
                      std::span<std::int8_t, kPlaneCountsSize>(next_counts, kPlaneCountsSize));
    EncodePlanes({}, position, std::span<float, kPlanesSize>(next_planes, kPlanesSize));
    next_counts += kPlaneCountsSize;
    next_planes += kPlanesSize;
  }
  const auto scales = PlaneScales({});
  const torch::Tensor expanded =
      ExpandPlanes(counts, torch::tensor(std::vector<float>(scales.begin(), scales.end())));
  EXPECT_LT((expanded - planes).abs().max().item<float>(), 1e-6F);
}

class TorchEvaluatorTest : public testing::TestWithParam<const char*> {
 protected:
  NetworkDescription description_ = NetworkByName(GetParam());
  Snapshot snapshot_ = RandomWeights(description_, /*seed=*/1);
  std::vector<State> states_ = PlayedStates(33, /*seed=*/2);
  std::vector<Position> positions_ = PositionsOf(states_);
};

TEST_P(TorchEvaluatorTest, AnswersAsTheModule) {
  const auto evaluator = MakeTorchEvaluator(snapshot_, {});
  EXPECT_EQ(evaluator->name(), "torch cpu fp32");
  const CanaryDifference difference =
      Compare(EvaluateAll(*evaluator, positions_), AnswersOfModule(snapshot_, positions_));
  EXPECT_LT(difference.policy, 1e-5F);
  EXPECT_LT(difference.value, 1e-5F);
}

TEST_P(TorchEvaluatorTest, ModuleAnswersAsTheReference) {
  ReferenceEvaluator reference(snapshot_);
  positions_.resize(10);
  const CanaryDifference difference =
      Compare(EvaluateAll(reference, positions_), AnswersOfModule(snapshot_, positions_));
  EXPECT_LT(difference.policy, 1e-5F);
  EXPECT_LT(difference.value, 1e-5F);
}

TEST_P(TorchEvaluatorTest, Bf16IsClose) {
  const auto exact = MakeTorchEvaluator(snapshot_, {});
  const auto rounded = MakeTorchEvaluator(snapshot_, {.precision = Precision::kBf16});
  EXPECT_EQ(rounded->name(), "torch cpu bf16");
  const CanaryDifference difference =
      Compare(EvaluateAll(*exact, positions_), EvaluateAll(*rounded, positions_));
  EXPECT_LT(difference.policy, 0.05F);
  EXPECT_LT(difference.value, 0.05F);
}

TEST_P(TorchEvaluatorTest, SnapshotSurvivesTheModule) {
  const WeightsSnapshot back = ToSnapshot(MakeNetwork(*snapshot_), snapshot_->version);
  EXPECT_EQ(back, *snapshot_);
}

TEST_P(TorchEvaluatorTest, FreshModulesOfOneSeedAreEqual) {
  const WeightsSnapshot a = ToSnapshot(MakeNetwork(description_, Rng(5)), 0);
  EXPECT_EQ(a, InitialWeights(description_, Rng(5)));
  EXPECT_FALSE(a == ToSnapshot(MakeNetwork(description_, Rng(6)), 0));
}

TEST_P(TorchEvaluatorTest, TrainingReachesEveryParameter) {
  Network network = MakeNetwork(*snapshot_);
  const NetworkOutput output = network(torch::ones({4, kPlaneCount, kBoardSize, kBoardSize}) *
                                       torch::arange(1, 5).reshape({4, 1, 1, 1}));
  torch::Tensor sum = output.value.sum() + output.policy_logits.select(1, 0).sum();
  if (output.others_logits.defined()) sum = sum + output.others_logits.select(2, 0).sum();
  sum.backward();
  std::int64_t parameters = 0;
  for (const auto& parameter : network->named_parameters()) {
    ASSERT_TRUE(parameter.value().grad().defined()) << parameter.key();
    parameters += parameter.value().numel();
  }
  EXPECT_EQ(parameters, ParameterCount(description_));
}

INSTANTIATE_TEST_SUITE_P(Networks, TorchEvaluatorTest, testing::Values("paper", "small"));

TEST(TorchEvaluator, RefusesWhatTheDeviceLacks) {
  const Snapshot snapshot = RandomWeights(SmallNetwork(), 1);
  EXPECT_THROW((void)MakeTorchEvaluator(snapshot, {.precision = Precision::kFp16}), Error);
  EXPECT_THROW(
      (void)MakeTorchEvaluator(snapshot, {.device = TorchDevice::kCuda, .cuda_index = 1000}),
      Error);
}

TEST(TorchEvaluator, LoadingAnotherDescriptionLeavesTheModule) {
  Network network = MakeNetwork(SmallNetwork(), Rng(1));
  const WeightsSnapshot before = ToSnapshot(network, 0);
  EXPECT_THROW(LoadWeights(*RandomWeights(PaperNetwork(), 1), network), Error);
  EXPECT_EQ(ToSnapshot(network, 0), before);
}

}  // namespace
}  // namespace powderkeg

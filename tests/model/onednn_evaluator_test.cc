#include "common/onednn/onednn_evaluator.h"

#include <gtest/gtest.h>

#include <thread>

#include "common/base/check.h"
#include "tests/model/positions.h"
#include "tests/model/reference_evaluator.h"

namespace powderkeg {
namespace {

class OnednnEvaluatorTest : public testing::TestWithParam<NetworkDescription> {
 protected:
  [[nodiscard]] CanaryDifference FromReference(Evaluator& evaluator) const {
    ReferenceEvaluator reference(snapshot_);
    return Compare(EvaluateAll(evaluator, positions_), EvaluateAll(reference, positions_));
  }

  Snapshot snapshot_ = RandomWeights(GetParam(), /*seed=*/1);
  // A whole slice and a remainder.
  std::vector<State> states_ = PlayedStates(11, /*seed=*/2);
  std::vector<Position> positions_ = PositionsOf(states_);
};

NetworkDescription OddNetwork() {
  using Kind = BlockDescription::Kind;
  NetworkDescription network;
  network.stem_channels = 24;
  network.blocks = {{.kind = Kind::kResidual, .expanded = 40, .channels = 40, .stride = 2},
                    {.kind = Kind::kResidual, .expanded = 40, .channels = 40, .stride = 1},
                    {.kind = Kind::kInvertedResidual, .expanded = 50, .channels = 20, .stride = 1},
                    {.kind = Kind::kInvertedResidual, .expanded = 33, .channels = 20, .stride = 2}};
  network.value_channels = 3;
  network.value_hidden = 10;
  network.policy_channels = 5;
  network.leaky_slope = 0.1F;
  return network;
}

TEST_P(OnednnEvaluatorTest, AnswersAsTheReference) {
  const auto evaluator = MakeOnednnEvaluator(snapshot_, Precision::kFp32);
  EXPECT_EQ(evaluator->name(), "onednn fp32");
  const CanaryDifference difference = FromReference(*evaluator);
  EXPECT_LT(difference.policy, 1e-4F);
  EXPECT_LT(difference.value, 1e-4F);
}

TEST_P(OnednnEvaluatorTest, Bf16IsClose) {
  const auto evaluator = MakeOnednnEvaluator(snapshot_, Precision::kBf16);
  EXPECT_EQ(evaluator->name(), HasBf16() ? "onednn bf16" : "onednn fp32");
  const CanaryDifference difference = FromReference(*evaluator);
  EXPECT_LT(difference.policy, 0.05F);
  EXPECT_LT(difference.value, 0.05F);
}

TEST_P(OnednnEvaluatorTest, Int8IsClose) {
  const auto evaluator = MakeOnednnEvaluator(snapshot_, Precision::kInt8);
  if (!HasInt8()) GTEST_SKIP() << "the processor has no VNNI";
  EXPECT_EQ(evaluator->name(), "onednn int8");
  const CanaryDifference difference = FromReference(*evaluator);
  EXPECT_LT(difference.policy, 0.05F);
  EXPECT_LT(difference.value, 0.1F);
}

// Actors of one run agree on what a network says.
TEST_P(OnednnEvaluatorTest, Int8IsTheSameForTheSameWeights) {
  const auto one = MakeOnednnEvaluator(snapshot_, Precision::kInt8);
  const auto other = MakeOnednnEvaluator(snapshot_, Precision::kInt8);
  EXPECT_EQ(EvaluateAll(*one, positions_), EvaluateAll(*other, positions_));
}

// A position's answer does not depend on its neighbours in the batch beyond rounding.
TEST_P(OnednnEvaluatorTest, EverySliceSizeGivesTheSameAnswers) {
  for (const Precision precision : {Precision::kFp32, Precision::kInt8}) {
    const auto evaluator = MakeOnednnEvaluator(snapshot_, precision);
    const std::vector<Evaluation> all = EvaluateAll(*evaluator, positions_);
    for (std::size_t count = 0; count <= 9; ++count) {
      const auto first = static_cast<std::ptrdiff_t>(all.size() - count);
      const std::vector<Position> some(positions_.begin() + first, positions_.end());
      const CanaryDifference difference =
          Compare(EvaluateAll(*evaluator, some), {all.begin() + first, all.end()});
      EXPECT_LT(difference.policy, 1e-5F) << evaluator->name() << count;
      EXPECT_LT(difference.value, 1e-5F) << evaluator->name() << count;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Networks, OnednnEvaluatorTest,
                         testing::Values(PaperNetwork(), SmallNetwork(), OddNetwork()));

TEST(OnednnEvaluator, TwoThreadsWorkIndependently) {
  const Snapshot snapshot = RandomWeights(SmallNetwork(), 1);
  const std::vector<State> states = PlayedStates(30, 2);
  const std::vector<Position> positions = PositionsOf(states);
  const auto first = MakeOnednnEvaluator(snapshot, Precision::kFp32);
  const auto second = MakeOnednnEvaluator(snapshot, Precision::kFp32);
  const std::vector<Evaluation> expected = EvaluateAll(*first, positions);
  std::array<int, 2> wrong{};
  const auto work = [&](Evaluator& evaluator, int& differences) {
    for (int i = 0; i < 20; ++i) differences += EvaluateAll(evaluator, positions) != expected;
  };
  {
    const std::jthread other([&] { work(*second, wrong[1]); });
    work(*first, wrong[0]);
  }
  EXPECT_EQ(wrong, (std::array<int, 2>{0, 0}));
}

// As the loops of an actor do when new weights have come.
TEST(OnednnEvaluator, ThreadsMakeTheirsAtTheSameTime) {
  const Snapshot snapshot = RandomWeights(SmallNetwork(), 1);
  const std::vector<State> states = PlayedStates(8, 2);
  const std::vector<Position> positions = PositionsOf(states);
  const auto answers = [&] {
    std::vector<Evaluation> all;
    const auto evaluator = MakeOnednnEvaluator(snapshot, Precision::kBf16);
    for (std::size_t count = 1; count <= positions.size(); ++count) {
      for (const Evaluation& evaluation : EvaluateAll(
               *evaluator, {positions.begin(), positions.begin() + static_cast<long>(count)})) {
        all.push_back(evaluation);
      }
    }
    return all;
  };
  std::array<std::vector<Evaluation>, 4> found;
  {
    std::vector<std::jthread> threads;
    for (auto& mine : found) threads.emplace_back([&] { mine = answers(); });
  }
  for (const auto& mine : found) EXPECT_EQ(mine, answers());
}

TEST(OnednnEvaluator, RefusesWhatItCannotDo) {
  const Snapshot good = RandomWeights(SmallNetwork(), 1);
  EXPECT_THROW((void)MakeOnednnEvaluator(good, Precision::kFp16), Error);
  auto bad = std::make_shared<WeightsSnapshot>(*good);
  bad->arrays.pop_back();
  EXPECT_THROW((void)MakeOnednnEvaluator(bad, Precision::kFp32), Error);
}

}  // namespace
}  // namespace powderkeg

#include "learner/train/fused_tower.h"

#include <gtest/gtest.h>

#include "common/model/planes.h"
#include "common/torch/snapshot_conversion.h"
#include "common/torch/torch_network.h"
#include "common/torch/torch_runtime.h"
#include "learner/train/training_pass.h"

namespace powderkeg {
namespace {

using Kind = BlockDescription::Kind;
using Arrays = std::vector<std::pair<std::string, torch::Tensor>>;

// Each agent is marked in one cell, some are not.
torch::Tensor RandomPlanes(int positions) {
  torch::Tensor planes =
      (torch::rand({positions, kPlaneCount, kBoardSize, kBoardSize}) < 0.2).to(torch::kFloat32);
  for (int position = 0; position < positions; ++position) {
    for (int agent = 0; agent < kAgentCount; ++agent) {
      torch::Tensor plane = planes[position][kOwnCellPlane + agent];
      plane.zero_();
      if ((position + agent) % 5 != 0) plane[(position + agent) % kBoardSize][agent] = 1;
    }
  }
  return planes;
}

// As if trained: norms that are not 1 and 0, heads that say something.
Network RandomNetwork(const NetworkDescription& description) {
  torch::manual_seed(1);
  Network network = MakeNetwork(description, Rng(3));
  const torch::NoGradGuard no_gradients;
  for (auto& parameter : network->named_parameters()) {
    if (parameter->dim() == 1) parameter->add_(0.2 * torch::randn_like(*parameter));
    if (parameter->dim() == 2) parameter->copy_(0.1 * torch::randn_like(*parameter));
  }
  return network;
}

torch::Tensor LossOf(const NetworkOutput& output) {
  torch::manual_seed(4);
  const auto cross_entropy = [](const torch::Tensor& logits) {
    const std::int64_t last = logits.dim() - 1;
    const torch::Tensor targets = torch::rand(logits.sizes()).softmax(last);
    return -(targets * logits.to(torch::kFloat32).log_softmax(last)).sum();
  };
  const torch::Tensor loss =
      cross_entropy(output.policy_logits) + (output.value.to(torch::kFloat32) - 0.5).square().sum();
  return output.others_logits.defined() ? loss + cross_entropy(output.others_logits) : loss;
}

// The gradients of all parameters, then the running statistics, after `passes` passes.
Arrays PassesOf(const NetworkDescription& description, Precision precision, int threads,
                int positions, int passes = 1) {
  Network network = RandomNetwork(description);
  TrainingPass pass(network, torch::kCPU, precision, threads);
  EXPECT_EQ(pass.fused(), precision == Precision::kBf16);
  torch::manual_seed(2);
  const torch::Tensor planes = RandomPlanes(positions);
  std::vector<float> values(planes.data_ptr<float>(), planes.data_ptr<float>() + planes.numel());
  for (int i = 0; i < passes; ++i) pass.Backward(LossOf(pass.Forward(values, positions)));
  Arrays arrays;
  for (const auto& parameter : network->named_parameters()) {
    arrays.emplace_back(parameter.key(), parameter->grad().contiguous().clone());
  }
  for (const auto& buffer : network->named_buffers()) {
    if (buffer->dim() > 0) arrays.emplace_back(buffer.key(), buffer->clone());
  }
  return arrays;
}

double Norm(const torch::Tensor& values) { return values.norm().item<double>(); }

// Relative to the array's own norm. Some gradients are 0 but for rounding (a bias that the next
// norm takes away again): these are compared with the largest array's.
void ExpectNear(const Arrays& got, const Arrays& expected, double tolerance) {
  ASSERT_EQ(got.size(), expected.size());
  double largest = 0;
  for (const auto& [name, values] : expected) largest = std::max(largest, Norm(values));
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const auto& [name, values] = expected[i];
    ASSERT_EQ(got[i].first, name);
    const double scale = std::max(Norm(values), 1e-3 * largest);
    EXPECT_LT(Norm(got[i].second - values) / scale, tolerance) << name;
  }
}

NetworkDescription NetworkOf(int stem_channels, std::vector<BlockDescription> blocks) {
  NetworkDescription description = SmallNetwork();
  description.stem_channels = stem_channels;
  description.blocks = std::move(blocks);
  if (TowerBoardSize(description) != kBoardSize) {
    description.own_hidden = description.others_hidden = 0;
  }
  return description;
}

class FusedTowerTest : public testing::Test {
 protected:
  void SetUp() override {
    InitialiseTorch(1);
    if (!FusedTower::CanRun(SmallNetwork())) GTEST_SKIP() << "no AVX-512 with bf16";
  }
};

struct Case {
  const char* name;
  NetworkDescription network;
  double tolerance;  // the deeper, the more the rounding of bf16 weighs
};

TEST_F(FusedTowerTest, GradientsAreThoseOfTheOperationsInFp32) {
  const std::vector<Case> cases{
      {"a stem alone", NetworkOf(16, {}), 0.08},
      {"32 channels", NetworkOf(32, {{Kind::kResidual, 32, 32, 1}}), 0.12},
      {"48 channels, no skip", NetworkOf(16, {{Kind::kResidual, 48, 48, 1}}), 0.12},
      {"inverted", NetworkOf(32, {{Kind::kInvertedResidual, 64, 32, 1}}), 0.12},
      {"inverted, stride 2", NetworkOf(16, {{Kind::kInvertedResidual, 80, 48, 2}}), 0.12},
      {"small", SmallNetwork(), 0.2},
      {"paper", PaperNetwork(), 0.3},
  };
  for (const Case& one : cases) {
    SCOPED_TRACE(one.name);
    ASSERT_TRUE(FusedTower::CanRun(one.network));
    ExpectNear(PassesOf(one.network, Precision::kBf16, 1, 37),
               PassesOf(one.network, Precision::kFp32, 1, 37), one.tolerance);
  }
}

TEST_F(FusedTowerTest, ThreadsAndFurtherPassesChangeNothingButTheLastBits) {
  const Arrays once = PassesOf(SmallNetwork(), Precision::kBf16, 1, 37);
  ExpectNear(PassesOf(SmallNetwork(), Precision::kBf16, 3, 37), once, 1e-3);
  Arrays twice = PassesOf(SmallNetwork(), Precision::kBf16, 1, 37, 2);
  for (auto& [name, values] : twice) {
    if (!name.ends_with("running_mean") && !name.ends_with("running_var")) values /= 2;
  }
  const Arrays plain_twice = PassesOf(SmallNetwork(), Precision::kFp32, 1, 37, 2);
  for (std::size_t i = 0; i < once.size(); ++i) {
    const bool statistics = once[i].first.find("running") != std::string::npos;
    ExpectNear({twice[i]}, {statistics ? plain_twice[i] : once[i]}, 0.01);
  }
}

TEST_F(FusedTowerTest, LeavesWhatItHasNoCodeForToLibTorch) {
  EXPECT_FALSE(FusedTower::CanRun(NetworkOf(24, {}))) << "channels";
  EXPECT_FALSE(FusedTower::CanRun(NetworkOf(16, {{Kind::kResidual, 16, 16, 2}}))) << "a stride";
  const NetworkDescription three_sizes =
      NetworkOf(16, {{Kind::kInvertedResidual, 16, 16, 2}, {Kind::kInvertedResidual, 16, 16, 2}});
  EXPECT_FALSE(FusedTower::CanRun(three_sizes)) << "a board of 3x3";
}

}  // namespace
}  // namespace powderkeg

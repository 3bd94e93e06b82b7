// FusedTower without LibTorch, so that sanitizers see every access; what its gradients are worth is
// tested in fused_tower_test.cc.

#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

#include "common/base/rng.h"
#include "common/model/planes.h"
#include "common/pommerman/types.h"
#include "learner/train/fused_tower.h"

namespace powderkeg {
namespace {

constexpr int kWorkers = 3;

void OneAfterTheOther(int count, const std::function<void(int)>& work) {
  for (int i = 0; i < count; ++i) work(i);
}

void OnThreads(int count, const std::function<void(int)>& work) {
  std::vector<std::jthread> threads;
  for (int i = 0; i < count; ++i) threads.emplace_back(work, i);
}

// Arrays of exactly the size that is asked for, of random values: what is beyond them is not ours.
class Arrays {
 public:
  float* Make(std::int64_t size) {
    arrays_.push_back(std::make_unique<float[]>(static_cast<std::size_t>(size)));
    for (std::int64_t i = 0; i < size; ++i) {
      arrays_.back()[static_cast<std::size_t>(i)] = static_cast<float>(rng_.Uniform() - 0.5);
    }
    return arrays_.back().get();
  }

 private:
  Rng rng_{/*seed=*/1};
  std::vector<std::unique_ptr<float[]>> arrays_;
};

// The gradients of all weights after passes over batches that grow and shrink.
std::vector<float> GradientsOf(const NetworkDescription& network, const ForEachWorker& for_each) {
  Arrays arrays;
  std::vector<ConvolutionParameters> parameters;
  std::vector<std::pair<const float*, std::int64_t>> gradients;
  for (const ArrayShape& array : ArraysOf(network)) {
    if (array.shape.size() != 4) continue;
    const std::int64_t size = ElementCount(array.shape);
    const std::int64_t outputs = array.shape[0];
    parameters.push_back({.weights = arrays.Make(size),
                          .norm_weights = arrays.Make(outputs),
                          .norm_biases = arrays.Make(outputs),
                          .running_mean = arrays.Make(outputs),
                          .running_variance = arrays.Make(outputs),
                          .weights_gradient = arrays.Make(size),
                          .norm_weights_gradient = arrays.Make(outputs),
                          .norm_biases_gradient = arrays.Make(outputs)});
    gradients.emplace_back(parameters.back().weights_gradient, size);
  }
  FusedTower tower(network, kWorkers, for_each);
  const int cells = TowerBoardSize(network) * TowerBoardSize(network);
  for (const int positions : {2, 7, 5}) {
    const float* const planes = arrays.Make(std::int64_t{positions} * kPlaneCount * kCellCount);
    const HeadArrays<float> heads = tower.Forward(positions, planes, parameters);
    const std::int64_t marked = std::int64_t{positions} * kAgentCount * heads.channels;
    tower.Backward({.value = arrays.Make(positions * network.value_channels * cells),
                    .policy = arrays.Make(positions * network.policy_channels * cells),
                    .marked = heads.marked == nullptr ? nullptr : arrays.Make(marked),
                    .channels = heads.channels},
                   parameters);
  }
  std::vector<float> all;
  for (const auto& [first, size] : gradients) all.insert(all.end(), first, first + size);
  return all;
}

TEST(FusedTowerThreads, ShareOutTheBatch) {
  if (!FusedTower::CanRun(SmallNetwork())) GTEST_SKIP() << "no AVX-512 with bf16";
  for (const char* name : {"small", "paper", "stem32+residual48x2", "stem16+inverted80-48-2",
                           "stem64+inverted16-64", "stem16"}) {
    SCOPED_TRACE(name);
    const NetworkDescription network = NetworkByName(name);
    ASSERT_TRUE(FusedTower::CanRun(network));
    EXPECT_EQ(GradientsOf(network, OnThreads), GradientsOf(network, OneAfterTheOther));
  }
}

}  // namespace
}  // namespace powderkeg

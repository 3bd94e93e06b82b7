#include "learner/train/adamw.h"

#include <gtest/gtest.h>

#include "common/base/check.h"

namespace powderkeg {
namespace {

// What LibTorch's own does with the same gradients, for arrays in both memory formats.
TEST(AdamW, StepsAsLibTorchsDoes) {
  torch::manual_seed(1);
  torch::nn::Conv2d ours(torch::nn::Conv2dOptions(3, 5, 3));
  torch::nn::Conv2d theirs(torch::nn::Conv2dOptions(3, 5, 3));
  for (const bool channels_last : {false, true}) {
    for (std::size_t i = 0; i < 2; ++i) {
      const torch::Tensor values = torch::randn_like(ours->parameters()[i]);
      ours->parameters()[i].set_data(
          channels_last && i == 0 ? values.contiguous(torch::MemoryFormat::ChannelsLast) : values);
      theirs->parameters()[i].set_data(values.clone());
    }
    AdamW optimizer(*ours, /*weight_decay=*/0.1, /*steps=*/0);
    torch::optim::AdamW expected(theirs->parameters(),
                                 torch::optim::AdamWOptions(0.01).weight_decay(0.1));
    for (int step = 0; step < 20; ++step) {
      optimizer.ZeroGradients();
      for (std::size_t i = 0; i < 2; ++i) {
        const torch::Tensor gradient = torch::randn_like(theirs->parameters()[i]);
        ours->parameters()[i].mutable_grad().add_(gradient);
        theirs->parameters()[i].mutable_grad() = gradient;
      }
      optimizer.Step(0.01);
      expected.step();
    }
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_TRUE(torch::allclose(ours->parameters()[i], theirs->parameters()[i], 1e-4, 1e-6));
    }
  }
}

TEST(AdamW, GoesOnFromItsArrays) {
  torch::nn::Linear layer(3, 2);
  AdamW first(*layer, 0, 0);
  EXPECT_TRUE(first.Arrays().empty()) << "before the first step";
  first.ZeroGradients();
  for (torch::Tensor& parameter : layer->parameters()) parameter.mutable_grad().add_(1);
  first.Step(0.1);
  const std::vector<NamedArray> arrays = first.Arrays();
  AdamW second(*layer, 0, first.steps());
  second.Restore(arrays);
  EXPECT_EQ(second.Arrays(), arrays);
  EXPECT_THROW(second.Restore({}), Error);
}

}  // namespace
}  // namespace powderkeg

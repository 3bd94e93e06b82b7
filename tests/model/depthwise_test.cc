#include "common/onednn/depthwise.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <tuple>

#include "common/base/rng.h"

namespace powderkeg::onednn {
namespace {

std::uint16_t ToBf16(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return static_cast<std::uint16_t>((bits + 0x7fff + (bits >> 16 & 1)) >> 16);
}

float FromBf16(std::uint16_t value) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(value) << 16);
}

float Random(Rng& rng) { return static_cast<float>(2 * rng.Uniform() - 1); }

FoldedConvolution RandomLayer(int channels, int stride, Rng& rng) {
  FoldedConvolution layer;
  layer.inputs = layer.outputs = layer.groups = channels;
  layer.kernel = 3;
  layer.stride = stride;
  for (int i = 0; i < 9 * channels; ++i) layer.weights.push_back(Random(rng));
  for (int i = 0; i < channels; ++i) layer.bias.push_back(Random(rng));
  return layer;
}

// One value of the result, by definition.
float Convolved(const FoldedConvolution& layer, int side, const std::uint16_t* source, int row,
                int column, int channel, float negative_slope) {
  double sum = layer.bias[static_cast<std::size_t>(channel)];
  for (int i = 0; i < 9; ++i) {
    const int from_row = row * layer.stride + i / 3 - 1;
    const int from_column = column * layer.stride + i % 3 - 1;
    if (from_row < 0 || from_row >= side || from_column < 0 || from_column >= side) continue;
    sum += layer.weights[static_cast<std::size_t>(channel * 9 + i)] *
           FromBf16(source[(from_row * side + from_column) * layer.inputs + channel]);
  }
  return static_cast<float>(sum > 0 ? sum : sum * negative_slope);
}

class DepthwiseKernelTest : public testing::TestWithParam<std::tuple<int, int, int>> {};

TEST_P(DepthwiseKernelTest, ConvolvesAsDefined) {
  const auto [channels, side, stride] = GetParam();
  constexpr int kPositions = 3;
  constexpr float kSlope = 0.2F;
  Rng rng(1);
  const FoldedConvolution layer = RandomLayer(channels, stride, rng);
  if (!DepthwiseKernel::CanRun(layer)) GTEST_SKIP() << "the processor has no AVX-512 with bf16";
  std::vector<std::uint16_t> source;
  for (int i = 0; i < kPositions * side * side * channels; ++i)
    source.push_back(ToBf16(Random(rng)));
  const int result_side = (side - 1) / stride + 1;
  const auto size = static_cast<std::size_t>(kPositions * result_side * result_side * channels);
  constexpr std::uint16_t kUntouched = 0x1234;
  std::vector<std::uint16_t> result(size + 1, kUntouched);
  DepthwiseKernel(layer, kSlope).Run(kPositions, side, source.data(), result.data());
  EXPECT_EQ(result.back(), kUntouched);
  for (std::size_t i = 0; i < size; ++i) {
    const int at = static_cast<int>(i);
    const int channel = at % channels;
    const int column = at / channels % result_side;
    const int row = at / channels / result_side % result_side;
    const int position = at / channels / result_side / result_side;
    const float expected = Convolved(layer, side, source.data() + position * side * side * channels,
                                     row, column, channel, kSlope);
    ASSERT_NEAR(FromBf16(result[i]), expected, 1e-5F + std::abs(expected) / 256)
        << position << " " << row << " " << column << " " << channel;
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, DepthwiseKernelTest,
                         testing::Combine(testing::Values(32, 96), testing::Values(1, 2, 6, 11),
                                          testing::Values(1, 2)));

TEST(DepthwiseKernel, LeavesOtherLayersAlone) {
  Rng rng(1);
  FoldedConvolution odd = RandomLayer(33, 1, rng);
  EXPECT_FALSE(DepthwiseKernel::CanRun(odd));
  FoldedConvolution full = RandomLayer(32, 1, rng);
  full.groups = 1;
  EXPECT_FALSE(DepthwiseKernel::CanRun(full));
  FoldedConvolution pointwise = RandomLayer(32, 1, rng);
  pointwise.kernel = 1;
  EXPECT_FALSE(DepthwiseKernel::CanRun(pointwise));
}

}  // namespace
}  // namespace powderkeg::onednn

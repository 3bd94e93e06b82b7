#include "common/onednn/depthwise.h"

#include <array>
#include <cstddef>

#include "common/base/check.h"

#if defined(__x86_64__)
#if !defined(__clang__)  // g++ 12 warns of its own intrinsics (GCC bug 105593)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>
#endif

namespace powderkeg::onednn {
namespace {

constexpr int kKernel = 3;
constexpr int kTaps = kKernel * kKernel;
constexpr int kBlock = 32;  // channels that are worked on together: a cache line of bf16

[[maybe_unused]] bool IsDepthwise(const FoldedConvolution& layer) {
  return layer.kernel == kKernel && layer.groups == layer.inputs && layer.outputs == layer.inputs &&
         layer.inputs % kBlock == 0;
}

}  // namespace

DepthwiseKernel::DepthwiseKernel(const FoldedConvolution& layer, float negative_slope)
    : channels_(layer.outputs),
      stride_(layer.stride),
      negative_slope_(negative_slope),
      taps_(layer.weights.size()),
      bias_(layer.bias),
      zeros_(static_cast<std::size_t>(layer.outputs)) {
  const auto channels = static_cast<std::size_t>(channels_);
  for (std::size_t channel = 0; channel < channels; ++channel) {
    for (std::size_t tap = 0; tap < kTaps; ++tap) {
      taps_[tap * channels + channel] = layer.weights[channel * kTaps + tap];
    }
  }
}

#if defined(__x86_64__)

// Whatever processor the rest is compiled for. Inlined, so that weights and sums stay in registers.
#define POWDERKEG_AVX512 __attribute__((target("avx512f,avx512bw,avx512vl,avx512bf16")))
#define POWDERKEG_AVX512_INLINE POWDERKEG_AVX512 __attribute__((always_inline)) inline

namespace {

constexpr int kLanes = 16;
constexpr int kVectors = kBlock / kLanes;

// One block of channels.
struct alignas(64) Block {
  __m512 lanes[kVectors];
};

// The three rows of the source that a row of the result needs, at one block of channels.
struct Rows {
  std::array<const std::uint16_t*, kKernel> first;
  std::array<std::ptrdiff_t, kKernel> step;  // to the next column; 0 beyond the edge
};

POWDERKEG_AVX512_INLINE Block LoadFloats(const float* from) {
  return {{_mm512_loadu_ps(from), _mm512_loadu_ps(from + kLanes)}};
}

// bf16 is the upper half of an fp32.
POWDERKEG_AVX512_INLINE Block LoadBf16(const std::uint16_t* from) {
  Block block;
  for (int i = 0; i < kVectors; ++i) {
    const __m256i half = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from + i * kLanes));
    block.lanes[i] = _mm512_castsi512_ps(_mm512_slli_epi32(_mm512_cvtepu16_epi32(half), 16));
  }
  return block;
}

// What a row of the result needs besides its source, at one block of channels.
struct Weights {
  std::array<Block, kTaps> taps;
  Block bias;
  __m512 negative_slope;
};

// Adds the product of a column of the source and a column of the kernel.
POWDERKEG_AVX512_INLINE void Accumulate(const std::array<Block, kKernel>& column,
                                        const Weights& weights, std::size_t kernel_column,
                                        Block& sum) {
  for (std::size_t row = 0; row < kKernel; ++row) {
    const Block& tap = weights.taps[row * kKernel + kernel_column];
    for (int i = 0; i < kVectors; ++i) {
      sum.lanes[i] = _mm512_fmadd_ps(column[row].lanes[i], tap.lanes[i], sum.lanes[i]);
    }
  }
}

POWDERKEG_AVX512_INLINE std::array<Block, kKernel> LoadColumn(const Rows& rows, int column) {
  std::array<Block, kKernel> values;
  for (std::size_t row = 0; row < kKernel; ++row) {
    values[row] = LoadBf16(rows.first[row] + column * rows.step[row]);
  }
  return values;
}

POWDERKEG_AVX512_INLINE void StoreActivated(const Block& sum, __m512 slope, std::uint16_t* to) {
  for (int i = 0; i < kVectors; ++i) {
    const __m512 active = _mm512_max_ps(sum.lanes[i], _mm512_mul_ps(sum.lanes[i], slope));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to + i * kLanes),
                        (__m256i)_mm512_cvtneps_pbh(active));
  }
}

// One row of the result. Each column of the source is read once, for the three sums it is part of.
POWDERKEG_AVX512_INLINE void ConvolveRow(const Rows& rows, int side, const Weights& weights,
                                         std::ptrdiff_t step, std::uint16_t* result) {
  Block left = weights.bias;
  Block centre = weights.bias;
  for (int column = 0; column < side; ++column) {
    const std::array<Block, kKernel> values = LoadColumn(rows, column);
    Block right = weights.bias;
    Accumulate(values, weights, 2, left);
    Accumulate(values, weights, 1, centre);
    Accumulate(values, weights, 0, right);
    if (column > 0) StoreActivated(left, weights.negative_slope, result + (column - 1) * step);
    left = centre;
    centre = right;
  }
  StoreActivated(left, weights.negative_slope, result + (side - 1) * step);
}

// The same with stride 2: even columns are centres, odd ones stand between two.
POWDERKEG_AVX512_INLINE void ConvolveRowStrided(const Rows& rows, int side, const Weights& weights,
                                                std::ptrdiff_t step, std::uint16_t* result) {
  Block sum = weights.bias;
  for (int column = 0; column < side; column += 2, result += step) {
    Accumulate(LoadColumn(rows, column), weights, 1, sum);
    Block next = weights.bias;
    if (column + 1 < side) {
      const std::array<Block, kKernel> between = LoadColumn(rows, column + 1);
      Accumulate(between, weights, 2, sum);
      Accumulate(between, weights, 0, next);
    }
    StoreActivated(sum, weights.negative_slope, result);
    sum = next;
  }
}

}  // namespace

bool DepthwiseKernel::CanRun(const FoldedConvolution& layer) {
  return IsDepthwise(layer) && __builtin_cpu_supports("avx512bf16") &&
         __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
}

POWDERKEG_AVX512 void DepthwiseKernel::RunRow(int row, int side, const std::uint16_t* source,
                                              std::uint16_t* result) const {
  for (int channel = 0; channel < channels_; channel += kBlock) {
    Rows rows;
    for (int i = 0; i < kKernel; ++i) {
      const int from = row * stride_ + i - kKernel / 2;
      const bool inside = from >= 0 && from < side;
      rows.first[static_cast<std::size_t>(i)] =
          inside ? source + from * side * channels_ + channel : zeros_.data();
      rows.step[static_cast<std::size_t>(i)] = inside ? channels_ : 0;
    }
    Weights weights;
    for (int tap = 0; tap < kTaps; ++tap) {
      weights.taps[static_cast<std::size_t>(tap)] =
          LoadFloats(taps_.data() + tap * channels_ + channel);
    }
    weights.bias = LoadFloats(bias_.data() + channel);
    weights.negative_slope = _mm512_set1_ps(negative_slope_);
    if (stride_ == 1) {
      ConvolveRow(rows, side, weights, channels_, result + channel);
    } else {
      ConvolveRowStrided(rows, side, weights, channels_, result + channel);
    }
  }
}

#else

bool DepthwiseKernel::CanRun(const FoldedConvolution&) { return false; }

void DepthwiseKernel::RunRow(int, int, const std::uint16_t*, std::uint16_t*) const {
  CHECK(false, "CanRun says no");
}

#endif

void DepthwiseKernel::Run(int positions, int side, const std::uint16_t* source,
                          std::uint16_t* result) const {
  const int result_side = (side - 1) / stride_ + 1;
  for (int position = 0; position < positions; ++position) {
    for (int row = 0; row < result_side; ++row) {
      RunRow(row, side, source, result);
      result += result_side * channels_;
    }
    source += side * side * channels_;
  }
}

}  // namespace powderkeg::onednn

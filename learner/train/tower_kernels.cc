#include "learner/train/tower_kernels.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <cstring>

#include "common/base/check.h"

#if defined(__x86_64__)
#if !defined(__clang__)  // g++ 12 warns of its own intrinsics (GCC bug 105593)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wuninitialized"
#endif
#include <immintrin.h>
#endif

namespace powderkeg::tower {
namespace {

constexpr int kLanes = 16;

constexpr int Taps(int kernel) { return kernel * kernel; }

// Outputs that are worked on together.
int BlockOf(const DenseShape& shape) { return shape.outputs % (2 * kLanes) == 0 ? 32 : 16; }

// To the nearest, ties to even; weights are finite.
Bf16 Round(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return static_cast<Bf16>((bits + 0x7FFF + (bits >> 16 & 1)) >> 16);
}

float Widen(Bf16 value) { return std::bit_cast<float>(std::uint32_t{value} << 16); }

// packed[block][tap][pair of inputs][output][2] = weight(output, input, tap).
template <typename Weight>
void Pack(const DenseShape& shape, Bf16* packed, Weight weight) {
  const int block = BlockOf(shape);
  for (int first = 0; first < shape.outputs; first += block) {
    for (int tap = 0; tap < Taps(shape.kernel); ++tap) {
      for (int input = 0; input < shape.inputs; input += 2) {
        for (int output = first; output < first + block; ++output) {
          *packed++ = Round(weight(output, input, tap));
          *packed++ = Round(weight(output, input + 1, tap));
        }
      }
    }
  }
}

}  // namespace

bool HasSide(int side) { return side == 11 || side == 6; }

std::size_t FieldSize(int side, int channels) {
  return static_cast<std::size_t>(((side + 2) * (side + 2) + 1) * channels);
}

std::size_t PairsSize(int side, int channels) { return FieldSize(side, channels); }

DenseShape Backwards(const DenseShape& shape) {
  return {shape.kernel, shape.side, shape.outputs, shape.inputs};
}

void PackForwards(const DenseShape& shape, int given_inputs, const float* weights, Bf16* packed) {
  const int taps = Taps(shape.kernel);
  Pack(shape, packed, [=](int output, int input, int tap) {
    return input < given_inputs ? weights[(output * given_inputs + input) * taps + tap] : 0.0F;
  });
}

void PackBackwards(const DenseShape& shape, const float* weights, Bf16* packed) {
  const int taps = Taps(shape.kernel);
  const int inputs = shape.inputs;
  Pack(Backwards(shape), packed, [=](int input, int output, int tap) {
    return weights[(output * inputs + input) * taps + taps - 1 - tap];
  });
}

#if defined(__x86_64__)

bool CanRun() {
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bf16");
}

// From here on, whatever processor the rest is compiled for.
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx512f,avx512bw,avx512vl,avx512bf16"))), \
                             apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx512f,avx512bw,avx512vl,avx512bf16")
#endif

namespace {

__m512 Load(const Bf16* from) {
  const __m256i half = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
  return _mm512_castsi512_ps(_mm512_slli_epi32(_mm512_cvtepu16_epi32(half), 16));
}

void Store(Bf16* to, __m512 values) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), (__m256i)_mm512_cvtneps_pbh(values));
}

void AddTo(double* sums, __m512 values) {
  const __m256 low = _mm512_castps512_ps256(values);
  const __m256 high =
      _mm256_castsi256_ps(_mm512_extracti64x4_epi64(_mm512_castps_si512(values), 1));
  _mm512_storeu_pd(sums, _mm512_add_pd(_mm512_loadu_pd(sums), _mm512_cvtps_pd(low)));
  _mm512_storeu_pd(sums + 8, _mm512_add_pd(_mm512_loadu_pd(sums + 8), _mm512_cvtps_pd(high)));
}

// 16 times one pair.
__m512i Broadcast(const void* pair) {
  std::int32_t one = 0;
  std::memcpy(&one, pair, sizeof one);
  return _mm512_set1_epi32(one);
}

// sum + the products of 16 pairs.
__m512 AddProducts(__m512 sum, __m512i a, __m512i b) {
  return _mm512_dpbf16_ps(sum, (__m512bh)a, (__m512bh)b);
}

// The offset of a cell of the inside of a field.
std::ptrdiff_t Inside(int side, int channels, int row, int column) {
  return static_cast<std::ptrdiff_t>((row + 1) * (side + 2) + column + 1) * channels;
}

// ---- Dense convolutions -------------------------------------------------------------------------

// kRows rows of the result. A cell is read once for all taps of its row of the kernel. kInputs: 0
// if not known here.
template <int kKernel, int kColumns, int kVectors, int kInputs, int kRows>
void ConvolveRows(const DenseShape& shape, const Bf16* cells, const Bf16* packed, float* result) {
  const int inputs = kInputs > 0 ? kInputs : shape.inputs;
  const int pitch = (kColumns + 2) * inputs;
  const int tap_size = inputs * kVectors * kLanes;
  __m512 sums[kRows * kColumns][kVectors];
  for (auto& of_cell : sums) {
    for (__m512& sum : of_cell) sum = _mm512_setzero_ps();
  }
  for (int tap_row = 0; tap_row < kKernel; ++tap_row, cells += pitch) {
    for (int input = 0; input < inputs; input += 2) {
      __m512i weights[kKernel][kVectors];
      for (int i = 0; i < kKernel * kVectors; ++i) {
        weights[i / kVectors][i % kVectors] = _mm512_loadu_si512(
            packed + i / kVectors * tap_size + (input * kVectors + i % kVectors * 2) * kLanes);
      }
#pragma GCC unroll 26
      for (int i = 0; i < kRows * (kColumns + kKernel - 1); ++i) {
        const int row = i / (kColumns + kKernel - 1);
        const int cell = i % (kColumns + kKernel - 1);
        const __m512i pair = Broadcast(cells + row * pitch + cell * inputs + input);
#pragma GCC unroll 3
        for (int tap = 0; tap < kKernel; ++tap) {
          const int column = cell - tap;
          if (column < 0 || column >= kColumns) continue;
          for (int vector = 0; vector < kVectors; ++vector) {
            __m512& sum = sums[row * kColumns + column][vector];
            sum = AddProducts(sum, weights[tap][vector], pair);
          }
        }
      }
    }
    packed += kKernel * tap_size;
  }
#pragma GCC unroll 22
  for (int cell = 0; cell < kRows * kColumns; ++cell) {
    for (int i = 0; i < kVectors; ++i) {
      _mm512_storeu_ps(result + cell * shape.outputs + i * kLanes, sums[cell][i]);
    }
  }
}

template <int kKernel, int kColumns, int kVectors, int kInputs>
void ConvolveField(const DenseShape& shape, const Bf16* field, const Bf16* packed, float* result) {
  constexpr int kRows = kVectors == 1 ? 2 : 1;  // as many sums as registers hold
  constexpr int kLeft = kColumns % kRows;
  const int pitch = (kColumns + 2) * shape.inputs;
  const Bf16* const first = field + (kKernel == 1 ? pitch + shape.inputs : 0);
  const int block = kVectors * kLanes;
  for (int output = 0; output < shape.outputs; output += block) {
    float* to = result + output;
    int row = 0;
    for (; row + kRows <= kColumns; row += kRows, to += kRows * kColumns * shape.outputs) {
      ConvolveRows<kKernel, kColumns, kVectors, kInputs, kRows>(shape, first + row * pitch, packed,
                                                                to);
    }
    if constexpr (kLeft > 0) {
      ConvolveRows<kKernel, kColumns, kVectors, kInputs, kLeft>(shape, first + row * pitch, packed,
                                                                to);
    }
    packed += kKernel * kKernel * shape.inputs * block;
  }
}

// With code of its own for the inputs of the known networks.
template <int kColumns, int kVectors>
void ConvolveSide(const DenseShape& shape, const Bf16* field, const Bf16* packed, float* result) {
  const auto run = [&]<int kKernel, int kInputs>() {
    ConvolveField<kKernel, kColumns, kVectors, kInputs>(shape, field, packed, result);
  };
  if (shape.kernel == 3) {
    switch (shape.inputs) {
      case 16: return run.template operator()<3, 16>();
      case 24: return run.template operator()<3, 24>();
      default: return run.template operator()<3, 0>();
    }
  }
  switch (shape.inputs) {
    case 64: return run.template operator()<1, 64>();
    case 128: return run.template operator()<1, 128>();
    case 256: return run.template operator()<1, 256>();
    case 512: return run.template operator()<1, 512>();
    default: return run.template operator()<1, 0>();
  }
}

// ---- Gradients of dense weights -----------------------------------------------------------------

// low[i], high[i] -> one pair, for 16 channels.
__m512i Pair(const Bf16* low, const Bf16* high) {
  const __m512i first =
      _mm512_cvtepu16_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(low)));
  const __m512i second =
      _mm512_cvtepu16_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(high)));
  return _mm512_or_si512(first, _mm512_slli_epi32(second, 16));
}

// Each of the cells and its right neighbour.
void PairCells(const Bf16* cell, int channels, std::uint32_t* pairs) {
  int channel = 0;
  for (; channel + kLanes <= channels; channel += kLanes) {
    _mm512_storeu_si512(pairs + channel, Pair(cell + channel, cell + channels + channel));
  }
  for (; channel < channels; ++channel) {
    pairs[channel] = cell[channel] | std::uint32_t{cell[channels + channel]} << 16;
  }
}

int PairsInARow(int side) { return (side + 1) / 2; }

// kInputs x kVectors sums over all cells.
template <int kInputs, int kVectors>
void AddProductsOverCells(const DenseShape& shape, const std::uint32_t* inputs,
                          std::ptrdiff_t row_step, std::ptrdiff_t pair_step,
                          const std::uint32_t* outputs, float* gradient) {
  const int pairs = PairsInARow(shape.side);
  __m512 sums[kInputs][kVectors];
  for (auto& of_input : sums) {
    for (__m512& sum : of_input) sum = _mm512_setzero_ps();
  }
  for (int row = 0; row < shape.side; ++row) {
    for (int pair = 0; pair < pairs; ++pair, outputs += shape.outputs) {
      const std::uint32_t* const cell = inputs + row * row_step + pair * pair_step;
      __m512i of_output[kVectors];
      for (int i = 0; i < kVectors; ++i) of_output[i] = _mm512_loadu_si512(outputs + i * kLanes);
#pragma GCC unroll 24
      for (int input = 0; input < kInputs; ++input) {
        const __m512i pair_of_input = Broadcast(cell + input);
        for (int i = 0; i < kVectors; ++i) {
          sums[input][i] = AddProducts(sums[input][i], of_output[i], pair_of_input);
        }
      }
    }
  }
#pragma GCC unroll 24
  for (int input = 0; input < kInputs; ++input) {
    for (int i = 0; i < kVectors; ++i) {
      float* const to = gradient + input * shape.outputs + i * kLanes;
      _mm512_storeu_ps(to, _mm512_add_ps(_mm512_loadu_ps(to), sums[input][i]));
    }
  }
}

template <int kInputs, int kVectors>
void AddWeightGradientIn(const DenseShape& shape, const std::uint32_t* inputs,
                         const std::uint32_t* outputs, float* gradient) {
  // See PairNeighbours: for 1x1 the pairs of the gradient's cells, else of every cell.
  const bool every = shape.kernel == 3;
  const std::ptrdiff_t pair_step = (every ? 2 : 1) * shape.inputs;
  const std::ptrdiff_t row_step = (every ? shape.side + 2 : PairsInARow(shape.side)) * shape.inputs;
  for (int tap = 0; tap < Taps(shape.kernel); ++tap) {
    const std::uint32_t* const first =
        inputs + tap / shape.kernel * row_step + tap % shape.kernel * shape.inputs;
    for (int output = 0; output < shape.outputs; output += kVectors * kLanes) {
      for (int input = 0; input < shape.inputs; input += kInputs) {
        AddProductsOverCells<kInputs, kVectors>(
            shape, first + input, row_step, pair_step, outputs + output,
            gradient + (tap * shape.inputs + input) * shape.outputs + output);
      }
    }
  }
}

// ---- Depthwise convolutions ---------------------------------------------------------------------

// Of one block of channels of a field.
struct Column {
  __m512 rows[3];
};

Column LoadColumn(const Bf16* top, std::ptrdiff_t pitch) {
  return {{Load(top), Load(top + pitch), Load(top + 2 * pitch)}};
}

__m512 AddColumn(__m512 sum, const Column& column, const __m512* taps) {
  for (int row = 0; row < 3; ++row) sum = _mm512_fmadd_ps(column.rows[row], taps[3 * row], sum);
  return sum;
}

}  // namespace

void FieldOfPlanes(int side, int planes, int channels, const float* values, Bf16* field) {
  const int cells = side * side;
  constexpr int kMostPairs = 32;
  alignas(64) std::uint32_t pairs[kMostPairs][kLanes];
  CHECK(planes <= channels && channels <= 2 * kMostPairs && channels % 2 == 0);
  for (int first = 0; first < cells; first += kLanes) {
    const int count = std::min(kLanes, cells - first);
    const auto lanes = static_cast<__mmask16>((1U << count) - 1);
    const auto load = [&](int plane) {
      const __mmask16 there = plane < planes ? lanes : __mmask16{0};
      const __m512 given = _mm512_maskz_loadu_ps(there, values + plane * cells + first);
      return _mm512_cvtepu16_epi32((__m256i)_mm512_cvtneps_pbh(given));
    };
    for (int plane = 0; plane < channels; plane += 2) {
      const __m512i pair = _mm512_or_si512(load(plane), _mm512_slli_epi32(load(plane + 1), 16));
      _mm512_store_si512(pairs[plane / 2], pair);
    }
    for (int lane = 0; lane < count; ++lane) {
      const int cell = first + lane;
      Bf16* const to = field + Inside(side, channels, cell / side, cell % side);
      for (int pair = 0; pair < channels / 2; ++pair) {
        std::memcpy(to + 2 * pair, &pairs[pair][lane], sizeof pairs[pair][lane]);
      }
    }
  }
}

void Convolve(const DenseShape& shape, const Bf16* field, const Bf16* packed, float* result) {
  const bool two = BlockOf(shape) == 2 * kLanes;
  if (shape.side == 11 && two) return ConvolveSide<11, 2>(shape, field, packed, result);
  if (shape.side == 11) return ConvolveSide<11, 1>(shape, field, packed, result);
  DCHECK(shape.side == 6);
  if (two) return ConvolveSide<6, 2>(shape, field, packed, result);
  return ConvolveSide<6, 1>(shape, field, packed, result);
}

void Convolve(const DepthwiseShape& shape, const Bf16* field, const float* taps, float* result) {
  const int channels = shape.channels;
  const std::ptrdiff_t pitch = static_cast<std::ptrdiff_t>(shape.side + 2) * channels;
  const int out = (shape.side - 1) / shape.stride + 1;
  for (int channel = 0; channel < channels; channel += kLanes) {
    __m512 weights[9];
    for (int tap = 0; tap < 9; ++tap)
      weights[tap] = _mm512_loadu_ps(taps + tap * channels + channel);
    float* to = result + channel;
    for (int row = 0; row < out; ++row) {
      const Bf16* from = field + row * shape.stride * pitch + channel;
      Column left = LoadColumn(from, pitch);
      Column middle = LoadColumn(from + channels, pitch);
      for (int column = 0; column < out; ++column, to += channels) {
        const Column right = LoadColumn(from + 2 * channels, pitch);
        __m512 sum = AddColumn(_mm512_setzero_ps(), left, weights);
        sum = AddColumn(sum, middle, weights + 1);
        _mm512_storeu_ps(to, AddColumn(sum, right, weights + 2));
        from += shape.stride * channels;
        left = shape.stride == 1 ? middle : right;
        middle = shape.stride == 1 ? right : LoadColumn(from + channels, pitch);
      }
    }
  }
}

void PairNeighbours(const DenseShape& shape, const Bf16* field, std::uint32_t* pairs) {
  if (shape.kernel == 1) return PairGradient(Backwards(shape), field, pairs);
  const int cells = (shape.side + 2) * (shape.side + 2);
  for (int cell = 0; cell < cells; ++cell) {
    PairCells(field + cell * shape.inputs, shape.inputs, pairs + cell * shape.inputs);
  }
}

void PairGradient(const DenseShape& shape, const Bf16* field, std::uint32_t* pairs) {
  for (int row = 0; row < shape.side; ++row) {
    for (int column = 0; column < shape.side; column += 2, pairs += shape.outputs) {
      PairCells(field + Inside(shape.side, shape.outputs, row, column), shape.outputs, pairs);
    }
  }
}

void AddWeightGradient(const DenseShape& shape, const std::uint32_t* inputs,
                       const std::uint32_t* outputs, float* gradient) {
  const bool two = BlockOf(shape) == 2 * kLanes;
  if (two) return AddWeightGradientIn<8, 2>(shape, inputs, outputs, gradient);
  if (shape.inputs % 16 == 0) return AddWeightGradientIn<16, 1>(shape, inputs, outputs, gradient);
  DCHECK(shape.inputs % 24 == 0);
  AddWeightGradientIn<24, 1>(shape, inputs, outputs, gradient);
}

void AddWeightGradient(const DepthwiseShape& shape, const Bf16* field, const Bf16* output_gradient,
                       float* gradient) {
  const int channels = shape.channels;
  const std::ptrdiff_t pitch = static_cast<std::ptrdiff_t>(shape.side + 2) * channels;
  for (int channel = 0; channel < channels; channel += kLanes) {
    __m512 sums[9];
    for (__m512& sum : sums) sum = _mm512_setzero_ps();
    for (int row = 0; row < shape.side; row += shape.stride) {
      for (int column = 0; column < shape.side; column += shape.stride) {
        const Bf16* const corner = field + row * pitch + column * channels + channel;
        const __m512 of_output =
            Load(output_gradient + Inside(shape.side, channels, row, column) + channel);
#pragma GCC unroll 9
        for (int tap = 0; tap < 9; ++tap) {
          const __m512 input = Load(corner + tap / 3 * pitch + tap % 3 * channels);
          sums[tap] = _mm512_fmadd_ps(input, of_output, sums[tap]);
        }
      }
    }
    for (int tap = 0; tap < 9; ++tap) {
      float* const to = gradient + tap * channels + channel;
      _mm512_storeu_ps(to, _mm512_add_ps(_mm512_loadu_ps(to), sums[tap]));
    }
  }
}

// ---- Norm and activation ------------------------------------------------------------------------

namespace {

// Calls Kernel<vectors>::Run(first channel, ...) for groups of channels that are as wide as their
// sums fit into registers: memory is best read in long pieces.
template <template <int> class Kernel, typename... Arguments>
void InGroups(int channels, Arguments... arguments) {
  const auto run = [&]<int kVectors>() {
    for (int channel = 0; channel < channels; channel += kVectors * kLanes) {
      Kernel<kVectors>::Run(channel, channels, arguments...);
    }
  };
  if (channels % (8 * kLanes) == 0) return run.template operator()<8>();
  if (channels % (4 * kLanes) == 0) return run.template operator()<4>();
  if (channels % (2 * kLanes) == 0) return run.template operator()<2>();
  run.template operator()<1>();
}

template <int kVectors>
struct Group {
  __m512 lanes[kVectors];

  static Group Zero() {
    Group group;
    for (__m512& lane : group.lanes) lane = _mm512_setzero_ps();
    return group;
  }
  void AddTo(double* sums) const {
    for (int i = 0; i < kVectors; ++i) tower::AddTo(sums + i * kLanes, lanes[i]);
  }
};

template <int kVectors>
struct RawStorer {
  static void Run(int channel, int channels, int cells, const float* result, Bf16* raw,
                  double* sums, double* squares) {
    auto sum = Group<kVectors>::Zero();
    auto square = Group<kVectors>::Zero();
    for (int cell = 0; cell < cells; ++cell) {
      const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(cell) * channels + channel;
      for (int i = 0; i < kVectors; ++i) {
        const __m512 value = _mm512_loadu_ps(result + first + i * kLanes);
        Store(raw + first + i * kLanes, value);
        sum.lanes[i] = _mm512_add_ps(sum.lanes[i], value);
        square.lanes[i] = _mm512_fmadd_ps(value, value, square.lanes[i]);
      }
    }
    sum.AddTo(sums + channel);
    square.AddTo(squares + channel);
  }
};

template <int kVectors>
struct ActivationPasser {
  static void Run(int channel, int channels, int side, const float* result, const Bf16* addend,
                  float slope, const Bf16* value_field, const Bf16* raw, Bf16* gradient,
                  double* sums, double* products) {
    const __m512 negative_slope = _mm512_set1_ps(slope);
    auto sum = Group<kVectors>::Zero();
    auto product = Group<kVectors>::Zero();
    std::ptrdiff_t cell = channel;
    for (int row = 0; row < side; ++row) {
      const Bf16* value = value_field + Inside(side, channels, row, 0) + channel;
      for (int column = 0; column < side; ++column, cell += channels, value += channels) {
        for (int i = 0; i < kVectors; ++i) {
          const std::ptrdiff_t at = cell + i * kLanes;
          __m512 passed = _mm512_loadu_ps(result + at);
          if (addend != nullptr) passed = _mm512_add_ps(passed, Load(addend + at));
          const __mmask16 falls =
              _mm512_cmp_ps_mask(Load(value + i * kLanes), _mm512_setzero_ps(), _CMP_LE_OQ);
          passed = _mm512_mask_mul_ps(passed, falls, passed, negative_slope);
          Store(gradient + at, passed);
          sum.lanes[i] = _mm512_add_ps(sum.lanes[i], passed);
          product.lanes[i] = _mm512_fmadd_ps(passed, Load(raw + at), product.lanes[i]);
        }
      }
    }
    sum.AddTo(sums + channel);
    product.AddTo(products + channel);
  }
};

}  // namespace

void StoreRaw(int cells, int channels, const float* result, Bf16* raw, double* sums,
              double* squares) {
  InGroups<RawStorer>(channels, cells, result, raw, sums, squares);
}

void MakeValue(int side, int channels, const Bf16* raw, const Affine& affine, const Bf16* addend,
               Bf16* kept, Bf16* field) {
  const __m512 slope = _mm512_set1_ps(affine.slope);
  for (int row = 0; row < side; ++row) {
    Bf16* to = field + Inside(side, channels, row, 0);
    for (int column = 0; column < side; ++column) {
      for (int channel = 0; channel < channels; channel += kLanes, raw += kLanes, to += kLanes) {
        __m512 value = _mm512_fmadd_ps(Load(raw), _mm512_loadu_ps(affine.scale + channel),
                                       _mm512_loadu_ps(affine.shift + channel));
        if (addend != nullptr) {
          value = _mm512_add_ps(value, Load(addend));
          addend += kLanes;
        }
        value = _mm512_max_ps(value, _mm512_mul_ps(value, slope));
        Store(to, value);
        if (kept != nullptr) {
          Store(kept, value);
          kept += kLanes;
        }
      }
    }
  }
}

void ThroughActivation(int side, int channels, const float* result, const Bf16* addend, float slope,
                       const Bf16* value_field, const Bf16* raw, Bf16* gradient, double* sums,
                       double* products) {
  InGroups<ActivationPasser>(channels, side, result, addend, slope, value_field, raw, gradient,
                             sums, products);
}

void ThroughNorm(int side, int channels, const Bf16* gradient, const Bf16* raw,
                 const NormGradient& norm, int field_side, int stride, Bf16* field) {
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      Bf16* to = field + Inside(field_side, channels, row * stride, column * stride);
      for (int channel = 0; channel < channels; channel += kLanes, to += kLanes) {
        const __m512 rest = _mm512_fmadd_ps(Load(raw), _mm512_loadu_ps(norm.of_raw + channel),
                                            _mm512_loadu_ps(norm.constant + channel));
        Store(to,
              _mm512_fmadd_ps(Load(gradient), _mm512_loadu_ps(norm.of_gradient + channel), rest));
        raw += kLanes;
        gradient += kLanes;
      }
    }
  }
}

void FieldOf(int side, int channels, const Bf16* values, Bf16* field) {
  const std::size_t row_size = sizeof(Bf16) * static_cast<std::size_t>(side * channels);
  for (int row = 0; row < side; ++row) {
    std::memcpy(field + Inside(side, channels, row, 0), values + row * side * channels, row_size);
  }
}

void AddCell(int side, int channels, const Bf16* field, int cell, float* to) {
  const Bf16* const from = field + Inside(side, channels, cell / side, cell % side);
  for (int channel = 0; channel < channels; ++channel) to[channel] += Widen(from[channel]);
}

void PlanesOf(int side, int channels, const Bf16* field, int first, int count, float* planes) {
  for (int channel = first; channel < first + count; ++channel) {
    for (int row = 0; row < side; ++row) {
      const Bf16* from = field + Inside(side, channels, row, 0) + channel;
      for (int column = 0; column < side; ++column, from += channels) *planes++ = Widen(*from);
    }
  }
}

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

#else  // no x86-64

namespace {
[[noreturn]] void Refuse() {
  CHECK(false, "CanRun says no");
  std::abort();
}
}  // namespace

bool CanRun() { return false; }
void FieldOfPlanes(int, int, int, const float*, Bf16*) { Refuse(); }
void Convolve(const DenseShape&, const Bf16*, const Bf16*, float*) { Refuse(); }
void Convolve(const DepthwiseShape&, const Bf16*, const float*, float*) { Refuse(); }
void PairNeighbours(const DenseShape&, const Bf16*, std::uint32_t*) { Refuse(); }
void PairGradient(const DenseShape&, const Bf16*, std::uint32_t*) { Refuse(); }
void AddWeightGradient(const DenseShape&, const std::uint32_t*, const std::uint32_t*, float*) {
  Refuse();
}
void AddWeightGradient(const DepthwiseShape&, const Bf16*, const Bf16*, float*) { Refuse(); }
void StoreRaw(int, int, const float*, Bf16*, double*, double*) { Refuse(); }
void MakeValue(int, int, const Bf16*, const Affine&, const Bf16*, Bf16*, Bf16*) { Refuse(); }
void FieldOf(int, int, const Bf16*, Bf16*) { Refuse(); }
void AddCell(int, int, const Bf16*, int, float*) { Refuse(); }
void PlanesOf(int, int, const Bf16*, int, int, float*) { Refuse(); }
void ThroughActivation(int, int, const float*, const Bf16*, float, const Bf16*, const Bf16*, Bf16*,
                       double*, double*) {
  Refuse();
}
void ThroughNorm(int, int, const Bf16*, const Bf16*, const NormGradient&, int, int, Bf16*) {
  Refuse();
}

#endif

}  // namespace powderkeg::tower

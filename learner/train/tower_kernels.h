#pragma once

// The arithmetic of FusedTower, of one position at a time, in AVX-512 with bf16 products. Internal
// to learner/train.
//
// A field is what a convolution reads: bf16 [side + 2][side + 2][channels] with a ring of zeros,
// and one more cell of zeros behind it. All other arrays are [cell][channel]. Channels are
// multiples of 16 (inputs of dense convolutions: or of 24). Sums over cells are added to doubles.

#include <cstddef>
#include <cstdint>

namespace powderkeg::tower {

using Bf16 = std::uint16_t;

// Of a convolution over all channels: 1x1 or 3x3, stride 1.
struct DenseShape {
  int kernel = 1;
  int side = 0;
  int inputs = 0;
  int outputs = 0;
};

// Of a 3x3 convolution of each channel by itself.
struct DepthwiseShape {
  int side = 0;    // of what is read
  int stride = 1;  // 1 or 2
  int channels = 0;
};

// Batch norm as it is applied, and what follows it: max(x, slope * x).
struct Affine {
  const float* scale;
  const float* shift;
  float slope;  // 1: nothing follows
};

// Whether the processor has what all of these need.
[[nodiscard]] bool CanRun();

// Whether the kernels know fields of this side.
[[nodiscard]] bool HasSide(int side);

// Elements of a field, and of the array that holds a field's neighbours in pairs.
[[nodiscard]] std::size_t FieldSize(int side, int channels);
[[nodiscard]] std::size_t PairsSize(int side, int channels);

// Weights in the order that Convolve reads, from [output][input][row][column]; `inputs` beyond
// `given_inputs` are 0. The second for the gradient of the input: Convolve by it takes that of the
// output (Backwards(shape)).
[[nodiscard]] DenseShape Backwards(const DenseShape& shape);
void PackForwards(const DenseShape& shape, int given_inputs, const float* weights, Bf16* packed);
void PackBackwards(const DenseShape& shape, const float* weights, Bf16* packed);

// [channel][cell] to the inside of a field of `channels`, of which `planes` are given.
void FieldOfPlanes(int side, int planes, int channels, const float* values, Bf16* field);

// result = the convolution.
void Convolve(const DenseShape& shape, const Bf16* field, const Bf16* packed, float* result);
// `taps`: [tap][channel].
void Convolve(const DepthwiseShape& shape, const Bf16* field, const float* taps, float* result);

// For AddWeightGradient: each cell of a field beside its right neighbour, as it meets the taps of
// `kernel`; and of the gradient, every second cell of the inside.
void PairNeighbours(const DenseShape& shape, const Bf16* field, std::uint32_t* pairs);
void PairGradient(const DenseShape& shape, const Bf16* field, std::uint32_t* pairs);
// gradient[tap][input][output] += the product of both.
void AddWeightGradient(const DenseShape& shape, const std::uint32_t* inputs,
                       const std::uint32_t* outputs, float* gradient);
// gradient[tap][channel] +=; that of the output lies in a field of the input's side, `stride`
// apart.
void AddWeightGradient(const DepthwiseShape& shape, const Bf16* field, const Bf16* output_gradient,
                       float* gradient);

// raw = result; its sums and sums of squares over the cells.
void StoreRaw(int cells, int channels, const float* result, Bf16* raw, double* sums,
              double* squares);

// value = activation(scale * raw + shift + addend), to the inside of the field and, where it is
// given, to `kept`. `addend` may be null.
void MakeValue(int side, int channels, const Bf16* raw, const Affine& affine, const Bf16* addend,
               Bf16* kept, Bf16* field);
// Into the inside of a field.
void FieldOf(int side, int channels, const Bf16* values, Bf16* field);
// The channels `first` to `first + count - 1` of a field, [channel][cell].
void PlanesOf(int side, int channels, const Bf16* field, int first, int count, float* planes);
// to[channel] += that of one cell of the board.
void AddCell(int side, int channels, const Bf16* field, int cell, float* to);

// gradient = (result + addend) * the activation's slope where the value lies, and its sums and
// those of its products with `raw`. `addend` may be null.
void ThroughActivation(int side, int channels, const float* result, const Bf16* addend, float slope,
                       const Bf16* value_field, const Bf16* raw, Bf16* gradient, double* sums,
                       double* products);

// Batch norm backwards: per channel of_gradient * gradient + of_raw * raw + constant, into the
// inside of a field of `field_side`, `stride` apart.
struct NormGradient {
  const float* of_gradient;
  const float* of_raw;
  const float* constant;
};
void ThroughNorm(int side, int channels, const Bf16* gradient, const Bf16* raw,
                 const NormGradient& norm, int field_side, int stride, Bf16* field);

}  // namespace powderkeg::tower

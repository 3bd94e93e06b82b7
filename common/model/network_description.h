#pragma once

// The architecture of a network as a value that travels with its weights.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace powderkeg {

inline constexpr float kBatchNormEpsilon = 1e-5F;

// One block of the tower. All convolutions have batch norm and no bias.
struct BlockDescription {
  enum class Kind : std::uint8_t {
    // 1x1 to `expanded`, depthwise 3x3 (stride 1 or 2), 1x1 to `channels`; activation after the
    // first two; sum with the block's input if it has a skip connection; no activation.
    kInvertedResidual = 0,
    // 3x3 (stride 1 or 2), activation, 3x3, sum if it has a skip connection, activation
    // (AlphaZero).
    kResidual = 1,
  };
  Kind kind = Kind::kInvertedResidual;
  int expanded = 0;  // channels inside; for kResidual equal to `channels`
  int channels = 0;  // channels out
  int stride = 1;    // 1, or 2: 11x11 -> 6x6

  friend bool operator==(const BlockDescription&, const BlockDescription&) = default;
};

// Stem (3x3 convolution, batch norm, activation), blocks, then two heads:
//   value:  1x1 -> value_channels, batch norm, activation, flatten, -> value_hidden, activation,
//           -> 1, tanh
//   policy: 1x1 -> policy_channels, batch norm, activation, flatten, -> 6 logits
// and, where own_hidden > 0, what the tower says of the viewer's own cell (the cell marked in plane
// 10; nothing is added where no cell is marked), the same for every cell of the board:
//   own:    channels of that cell -> own_hidden, activation, -> added to the value's hidden layer
//           before its activation, and -> added to the 6 logits
// Where others_hidden > 0 it also says what each of the others will do next, from what the tower
// has of the cell where that one stands (marked in planes 11 to 13; nothing where none is), with
// the same weights for all of them:
//   others: channels of that cell -> others_hidden, activation, -> 6 logits
// Every activation is LeakyReLU(leaky_slope); batch norm divides by sqrt(variance +
// kBatchNormEpsilon). Convolutions of 3x3 pad the board with one ring of zeros.
struct NetworkDescription {
  int planes = 23;  // must equal kPlaneCount of the program that uses it
  int stem_channels = 0;
  int stem_stride = 1;
  std::vector<BlockDescription> blocks;
  int value_channels = 1;
  int value_hidden = 0;
  int policy_channels = 0;
  int own_hidden = 0;     // 0: no own head, as in the paper; else the tower must stay 11x11
  int others_hidden = 0;  // 0: foretells nobody, as in the paper; else as own_hidden
  float leaky_slope = 0.2F;

  friend bool operator==(const NetworkDescription&, const NetworkDescription&) = default;
};

// The network of the paper (344,425 parameters, 21.5 M multiply-adds).
[[nodiscard]] NetworkDescription PaperNetwork();
// A network for learning on CPUs (53,893 parameters, 1.6 M multiply-adds): an own head, and one
// that foretells the others, on a tower in which each cell sees the 11x11 cells around it.
[[nodiscard]] NetworkDescription SmallNetwork();
// "paper", "small", or its parts with '+' between them, in the order of the tower:
//   stemCHANNELS[-STRIDE], first and always
//   residualCHANNELS[-STRIDE][xTIMES], invertedEXPANDED-CHANNELS[-STRIDE][xTIMES]
//   valueCHANNELS-HIDDEN, policyCHANNELS, ownHIDDEN, othersHIDDEN; left out: as in `small`, without
//   the last two where a stride makes the board smaller
// such as stem32+residual32x4. Throws Error otherwise.
[[nodiscard]] NetworkDescription NetworkByName(std::string_view name);

// Throws Error with the reason if no network can be built from it or it needs absurd resources (it
// may come from a peer).
void Validate(const NetworkDescription& description);

// Side length of the board after the tower: 11, 6, 3 ...
[[nodiscard]] int TowerBoardSize(const NetworkDescription& description);

// Whether the block adds its input, of `inputs` channels, to its output: stride 1 and the channels
// stay.
[[nodiscard]] bool HasSkip(const BlockDescription& block, int inputs);

// Name and shape of every array of the network, batch norm statistics included, in a fixed order.
// "stem.conv.weight" [out, in, 3, 3]; "stem.bn.weight|bias|running_mean|running_var" [out];
// "blocks.<i>.conv<1..3>.weight" and ".bn<1..3>.*" (kResidual: 1..2); depthwise weights are
// [channels, 1, 3, 3]; "value.conv|bn|fc1|fc2.*", "policy.conv|bn|fc.*" (fc: weight [out, in] and
// bias [out]; the flattened order is channel, row, column); where there is an own head
// "own.fc.weight|bias", "own.value.weight", "own.policy.weight"; where the others are foretold
// "others.fc|policy.weight|bias".
struct ArrayShape {
  std::string name;
  std::vector<std::int64_t> shape;
};
[[nodiscard]] std::vector<ArrayShape> ArraysOf(const NetworkDescription& description);

// The product of the dimensions. Requires a shape from ArraysOf.
[[nodiscard]] std::int64_t ElementCount(std::span<const std::int64_t> shape);
// Trained values: every array but the running statistics.
[[nodiscard]] std::int64_t ParameterCount(const NetworkDescription& description);

}  // namespace powderkeg

#include "common/model/network_description.h"

#include <cmath>
#include <initializer_list>

#include "common/base/check.h"
#include "common/model/planes.h"

namespace powderkeg {
namespace {

using Kind = BlockDescription::Kind;
using Shape = std::vector<std::int64_t>;

constexpr int kMaxChannels = 2048;
constexpr std::size_t kMaxBlocks = 64;
constexpr std::int64_t kMaxParameters = 100'000'000;

void RequireRange(std::string_view what, int value, int low, int high) {
  if (value < low || value > high) {
    throw Error(
        StrCat("network description: ", what, " is ", value, ", expected ", low, " to ", high));
  }
}

void ValidateBlock(const BlockDescription& block, std::size_t index) {
  const std::string name = StrCat("block ", index, " ");
  RequireRange(name + "kind", static_cast<int>(block.kind), 0, static_cast<int>(Kind::kResidual));
  RequireRange(name + "channels", block.channels, 1, kMaxChannels);
  RequireRange(name + "expanded", block.expanded, 1, kMaxChannels);
  RequireRange(name + "stride", block.stride, 1, 2);
  if (block.kind == Kind::kResidual && block.expanded != block.channels) {
    throw Error(StrCat("network description: ", name, "is residual with ", block.expanded,
                       " channels inside, expected ", block.channels, " as outside"));
  }
}

// Collects the arrays of the network in their order.
class ArrayList {
 public:
  void AddConvolution(const std::string& prefix, const std::string& suffix, Shape shape) {
    const std::int64_t outputs = shape[0];
    Add(prefix + "conv" + suffix + ".weight", std::move(shape));
    for (const char* part : {"weight", "bias", "running_mean", "running_var"}) {
      Add(prefix + "bn" + suffix + "." + part, {outputs});
    }
  }
  void AddLinear(const std::string& name, std::int64_t outputs, std::int64_t inputs) {
    AddMatrix(name, outputs, inputs);
    Add(name + ".bias", {outputs});
  }
  void AddBlock(const std::string& prefix, int inputs, const BlockDescription& block) {
    if (block.kind == Kind::kResidual) {
      AddConvolution(prefix, "1", {block.channels, inputs, 3, 3});
      AddConvolution(prefix, "2", {block.channels, block.channels, 3, 3});
    } else {
      AddConvolution(prefix, "1", {block.expanded, inputs, 1, 1});
      AddConvolution(prefix, "2", {block.expanded, 1, 3, 3});
      AddConvolution(prefix, "3", {block.channels, block.expanded, 1, 1});
    }
  }
  void AddMatrix(const std::string& name, std::int64_t outputs, std::int64_t inputs) {
    Add(name + ".weight", {outputs, inputs});
  }
  [[nodiscard]] std::vector<ArrayShape> Take() { return std::move(arrays_); }

 private:
  void Add(std::string name, Shape shape) {
    arrays_.push_back({std::move(name), std::move(shape)});
  }

  std::vector<ArrayShape> arrays_;
};

}  // namespace

NetworkDescription PaperNetwork() {
  NetworkDescription network;
  network.stem_channels = 64;
  network.blocks = {
      {.kind = Kind::kInvertedResidual, .expanded = 256, .channels = 64, .stride = 1},
      {.kind = Kind::kInvertedResidual, .expanded = 256, .channels = 64, .stride = 1},
      {.kind = Kind::kInvertedResidual, .expanded = 512, .channels = 128, .stride = 2},
      {.kind = Kind::kInvertedResidual, .expanded = 512, .channels = 128, .stride = 1},
  };
  network.value_channels = 1;
  network.value_hidden = 256;
  network.policy_channels = 16;
  return network;
}

NetworkDescription SmallNetwork() {
  NetworkDescription network;
  network.stem_channels = 16;
  network.blocks = {
      {.kind = Kind::kResidual, .expanded = 16, .channels = 16, .stride = 1},
      {.kind = Kind::kResidual, .expanded = 16, .channels = 16, .stride = 1},
  };
  network.value_channels = 4;
  network.value_hidden = 64;
  network.policy_channels = 4;
  network.own_hidden = 64;
  network.others_hidden = 64;
  return network;
}

void Validate(const NetworkDescription& description) {
  RequireRange("planes", description.planes, kPlaneCount, kPlaneCount);
  RequireRange("stem_channels", description.stem_channels, 1, kMaxChannels);
  RequireRange("stem_stride", description.stem_stride, 1, 2);
  RequireRange("value_channels", description.value_channels, 1, kMaxChannels);
  RequireRange("value_hidden", description.value_hidden, 1, kMaxChannels);
  RequireRange("policy_channels", description.policy_channels, 1, kMaxChannels);
  RequireRange("own_hidden", description.own_hidden, 0, kMaxChannels);
  RequireRange("others_hidden", description.others_hidden, 0, kMaxChannels);
  if (!(description.leaky_slope >= 0.0F && description.leaky_slope <= 1.0F)) {
    throw Error(StrCat("network description: leaky_slope is ", description.leaky_slope,
                       ", expected 0 to 1"));
  }
  RequireRange("number of blocks",
               static_cast<int>(std::min(description.blocks.size(), kMaxBlocks + 1)), 0,
               static_cast<int>(kMaxBlocks));
  for (std::size_t i = 0; i < description.blocks.size(); ++i)
    ValidateBlock(description.blocks[i], i);
  if (TowerBoardSize(description) != kBoardSize) {
    RequireRange("own_hidden with a stride", description.own_hidden, 0, 0);
    RequireRange("others_hidden with a stride", description.others_hidden, 0, 0);
  }
  const std::int64_t parameters = ParameterCount(description);
  if (parameters > kMaxParameters) {
    throw Error(StrCat("network description: ", parameters, " parameters, expected at most ",
                       kMaxParameters));
  }
}

int TowerBoardSize(const NetworkDescription& description) {
  int size = (kBoardSize - 1) / description.stem_stride + 1;
  for (const BlockDescription& block : description.blocks) size = (size - 1) / block.stride + 1;
  return size;
}

bool HasSkip(const BlockDescription& block, int inputs) {
  return block.stride == 1 && block.channels == inputs;
}

std::vector<ArrayShape> ArraysOf(const NetworkDescription& description) {
  ArrayList list;
  list.AddConvolution("stem.", "", {description.stem_channels, description.planes, 3, 3});
  int channels = description.stem_channels;
  for (std::size_t i = 0; i < description.blocks.size(); ++i) {
    list.AddBlock(StrCat("blocks.", i, "."), channels, description.blocks[i]);
    channels = description.blocks[i].channels;
  }
  const std::int64_t size = TowerBoardSize(description);
  list.AddConvolution("value.", "", {description.value_channels, channels, 1, 1});
  list.AddLinear("value.fc1", description.value_hidden, description.value_channels * size * size);
  list.AddLinear("value.fc2", 1, description.value_hidden);
  list.AddConvolution("policy.", "", {description.policy_channels, channels, 1, 1});
  list.AddLinear("policy.fc", kActionCount, description.policy_channels * size * size);
  if (description.own_hidden > 0) {
    list.AddLinear("own.fc", description.own_hidden, channels);
    list.AddMatrix("own.value", description.value_hidden, description.own_hidden);
    list.AddMatrix("own.policy", kActionCount, description.own_hidden);
  }
  if (description.others_hidden > 0) {
    list.AddLinear("others.fc", description.others_hidden, channels);
    list.AddLinear("others.policy", kActionCount, description.others_hidden);
  }
  return list.Take();
}

std::int64_t ElementCount(std::span<const std::int64_t> shape) {
  std::int64_t count = 1;
  for (const std::int64_t dimension : shape) count *= dimension;
  return count;
}

std::int64_t ParameterCount(const NetworkDescription& description) {
  std::int64_t count = 0;
  for (const ArrayShape& array : ArraysOf(description)) {
    if (array.name.find(".running_") == std::string::npos) count += ElementCount(array.shape);
  }
  return count;
}

}  // namespace powderkeg

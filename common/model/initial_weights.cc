#include <cmath>
#include <string_view>

#include "common/model/weights_snapshot.h"

namespace powderkeg {
namespace {

// Width of the last layers relative to what keeps the variance.
constexpr float kLastLayerGain = 0.1F;

bool IsLastLayer(std::string_view name) {
  return name == "value.fc2.weight" || name == "policy.fc.weight" || name == "own.policy.weight";
}

bool IsVectorOfOnes(std::string_view name) {
  return name.ends_with(".running_var") ||
         (name.ends_with(".weight") && name.find(".bn") != std::string_view::npos);
}

// He, Zhang, Ren, Sun 2015, equation 15: uniform with variance 2 / ((1 + slope^2) fan_in).
void FillWeights(const ArrayShape& array, float slope, Rng rng, std::vector<float>& values) {
  const auto fan_in = static_cast<float>(ElementCount(array.shape) / array.shape[0]);
  const float gain = IsLastLayer(array.name) ? kLastLayerGain : 1.0F;
  const float bound = gain * std::sqrt(6.0F / ((1.0F + slope * slope) * fan_in));
  for (float& value : values) value = bound * (2.0F * static_cast<float>(rng.Uniform()) - 1.0F);
}

}  // namespace

WeightsSnapshot InitialWeights(const NetworkDescription& description, Rng rng) {
  Validate(description);
  WeightsSnapshot snapshot;
  snapshot.description = description;
  for (const ArrayShape& array : ArraysOf(description)) {
    std::vector<float> values(static_cast<std::size_t>(ElementCount(array.shape)), 0.0F);
    if (IsVectorOfOnes(array.name)) {
      values.assign(values.size(), 1.0F);
    } else if (array.shape.size() > 1) {
      FillWeights(array, description.leaky_slope, rng.Split(snapshot.arrays.size()), values);
    }
    snapshot.arrays.push_back({array.name, array.shape, std::move(values)});
  }
  return snapshot;
}

Snapshot LoadModel(const std::string& name) {
  constexpr std::string_view kUntrained = "untrained:";
  if (!name.starts_with(kUntrained)) return LoadSnapshot(name);
  const NetworkDescription network = NetworkByName(name.substr(kUntrained.size()));
  return std::make_shared<const WeightsSnapshot>(InitialWeights(network, Rng(1)));
}

}  // namespace powderkeg

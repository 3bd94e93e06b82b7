#include <cmath>
#include <string_view>

#include "common/model/weights_snapshot.h"

namespace powderkeg {
namespace {

// Width of the last layers relative to what keeps the variance.
constexpr float kLastLayerGain = 0.1F;

bool IsLastLayer(std::string_view name) {
  return name == "value.fc2.weight" || name == "policy.fc.weight" || name == "own.policy.weight" ||
         name == "others.policy.weight";
}

bool IsOfBatchNorm(std::string_view name) { return name.find(".bn") != std::string_view::npos; }

bool IsVectorOfOnes(std::string_view name) {
  return name.ends_with(".running_var") || (name.ends_with(".weight") && IsOfBatchNorm(name));
}

float FanIn(const ArrayShape& array) {
  return static_cast<float>(ElementCount(array.shape) / array.shape[0]);
}

// He, Zhang, Ren, Sun 2015, equation 15: uniform with variance 2 / ((1 + slope^2) fan_in).
float HeBound(const ArrayShape& array, float slope) {
  const float gain = IsLastLayer(array.name) ? kLastLayerGain : 1.0F;
  return gain * std::sqrt(6.0F / ((1.0F + slope * slope) * FanIn(array)));
}

}  // namespace

WeightsSnapshot InitialWeights(const NetworkDescription& description, Rng rng,
                               Initialisation initialisation) {
  Validate(description);
  const bool he = initialisation == Initialisation::kHe;
  WeightsSnapshot snapshot;
  snapshot.description = description;
  float layer_bound = 0;  // of kPytorch: of the layer that a bias belongs to
  for (const ArrayShape& array : ArraysOf(description)) {
    std::vector<float> values(static_cast<std::size_t>(ElementCount(array.shape)), 0.0F);
    float bound = 0;
    if (array.shape.size() > 1) {
      layer_bound = 1 / std::sqrt(FanIn(array));
      bound = he ? HeBound(array, description.leaky_slope) : layer_bound;
    } else if (!he && array.name.ends_with(".bias") && !IsOfBatchNorm(array.name)) {
      bound = layer_bound;
    }
    if (IsVectorOfOnes(array.name)) {
      values.assign(values.size(), 1.0F);
    } else if (bound > 0) {
      Rng random = rng.Split(snapshot.arrays.size());
      for (float& value : values) {
        value = bound * (2.0F * static_cast<float>(random.Uniform()) - 1.0F);
      }
    }
    snapshot.arrays.push_back({array.name, array.shape, std::move(values)});
  }
  return snapshot;
}

}  // namespace powderkeg

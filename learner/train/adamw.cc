#include "learner/train/adamw.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/check.h"

namespace powderkeg {
namespace {

constexpr const char* kFirstMoment = ".exp_avg";
constexpr const char* kSecondMoment = ".exp_avg_sq";
constexpr double kFirstBeta = 0.9;
constexpr double kSecondBeta = 0.999;
constexpr double kEpsilon = 1e-8;

NamedArray ToArray(std::string name, const torch::Tensor& tensor) {
  const torch::Tensor values = tensor.to(torch::kCPU, torch::kFloat32).contiguous();
  const float* const first = values.data_ptr<float>();
  return {std::move(name), tensor.sizes().vec(), {first, first + values.numel()}};
}

void CopyFromArray(const std::vector<NamedArray>& arrays, const std::string& name,
                   torch::Tensor& to) {
  const auto found = std::ranges::find(arrays, name, &NamedArray::name);
  if (found == arrays.end()) throw Error(StrCat("optimizer state: ", name, " is missing"));
  if (to.sizes() != torch::IntArrayRef(found->shape)) {
    throw Error(StrCat("optimizer state: ", name, " has another shape than its parameter"));
  }
  to.copy_(torch::from_blob(const_cast<float*>(found->values.data()), found->shape));
}

// What a step is for all parameters.
struct StepSizes {
  float kept;            // of a parameter
  float step;            // of the first moment over the root of the second
  float root_of_second;  // of the second moment's correction
};

// One pass over memory. All arrays have the same order of elements.
void StepOnCpu(const StepSizes& sizes, std::int64_t count, const float* gradient, float* values,
               float* first_moment, float* second_moment) {
  constexpr auto kFirst = static_cast<float>(kFirstBeta);
  constexpr auto kSecond = static_cast<float>(kSecondBeta);
  for (std::int64_t i = 0; i < count; ++i) {
    const float g = gradient[i];
    first_moment[i] = kFirst * first_moment[i] + (1 - kFirst) * g;
    second_moment[i] = kSecond * second_moment[i] + (1 - kSecond) * g * g;
    const float root =
        std::sqrt(second_moment[i]) / sizes.root_of_second + static_cast<float>(kEpsilon);
    values[i] = sizes.kept * values[i] - sizes.step * first_moment[i] / root;
  }
}

}  // namespace

AdamW::AdamW(const torch::nn::Module& module, double weight_decay, std::uint64_t steps)
    : weight_decay_(weight_decay), steps_(steps) {
  const torch::NoGradGuard no_gradients;
  for (const auto& parameter : module.named_parameters()) {
    parameters_.push_back({parameter.key(), *parameter, torch::zeros_like(*parameter),
                           torch::zeros_like(*parameter)});
  }
}

void AdamW::Restore(const std::vector<NamedArray>& arrays) {
  const torch::NoGradGuard no_gradients;
  for (Parameter& parameter : parameters_) {
    CopyFromArray(arrays, parameter.name + kFirstMoment, parameter.first_moment);
    CopyFromArray(arrays, parameter.name + kSecondMoment, parameter.second_moment);
  }
}

std::vector<NamedArray> AdamW::Arrays() const {
  std::vector<NamedArray> arrays;
  if (steps_ == 0) return arrays;
  for (const Parameter& parameter : parameters_) {
    arrays.push_back(ToArray(parameter.name + kFirstMoment, parameter.first_moment));
    arrays.push_back(ToArray(parameter.name + kSecondMoment, parameter.second_moment));
  }
  return arrays;
}

void AdamW::ZeroGradients() {
  for (Parameter& parameter : parameters_) {
    torch::Tensor& gradient = parameter.values.mutable_grad();
    if (gradient.defined()) {
      gradient.zero_();
    } else {
      gradient = torch::zeros_like(parameter.values);
    }
  }
}

void AdamW::Step(double learning_rate) {
  const torch::NoGradGuard no_gradients;
  ++steps_;
  const auto steps = static_cast<double>(steps_);
  const double first_correction = 1 - std::pow(kFirstBeta, steps);
  const double second_root = std::sqrt(1 - std::pow(kSecondBeta, steps));
  const double kept = 1 - learning_rate * weight_decay_;
  const double step = learning_rate / first_correction;
  const StepSizes sizes{static_cast<float>(kept), static_cast<float>(step),
                        static_cast<float>(second_root)};
  for (auto& [name, values, first, second] : parameters_) {
    const torch::Tensor& gradient = values.grad();
    if (values.device().is_cpu() && gradient.strides() == values.strides()) {
      StepOnCpu(sizes, values.numel(), gradient.data_ptr<float>(), values.data_ptr<float>(),
                first.data_ptr<float>(), second.data_ptr<float>());
      continue;
    }
    first.mul_(kFirstBeta).add_(gradient, 1 - kFirstBeta);
    second.mul_(kSecondBeta).addcmul_(gradient, gradient, 1 - kSecondBeta);
    values.mul_(kept).addcdiv_(first, second.sqrt().div_(second_root).add_(kEpsilon), -step);
  }
}

}  // namespace powderkeg

#include "common/torch/snapshot_conversion.h"

#include <algorithm>

#include "common/base/check.h"

namespace powderkeg {
namespace {

using NamedTensors = torch::OrderedDict<std::string, torch::Tensor>;

NamedTensors TensorsOf(const Network& network) {
  NamedTensors tensors = network->named_parameters();
  tensors.update(network->named_buffers());
  return tensors;
}

torch::Tensor TensorOf(const NamedTensors& tensors, const ArrayShape& array) {
  const torch::Tensor* const tensor = tensors.find(array.name);
  CHECK(tensor != nullptr && tensor->sizes() == torch::IntArrayRef(array.shape), array.name);
  return *tensor;
}

}  // namespace

Network MakeNetwork(const NetworkDescription& description, Rng rng) {
  return MakeNetwork(InitialWeights(description, rng));
}

Network MakeNetwork(const WeightsSnapshot& snapshot) {
  Network network(snapshot.description);
  LoadWeights(snapshot, network);
  return network;
}

void LoadWeights(const WeightsSnapshot& snapshot, Network& network) {
  Validate(snapshot);
  if (snapshot.description != network->description()) {
    throw Error("weights: the snapshot's network description is not that of the module");
  }
  const torch::NoGradGuard no_grad;
  const NamedTensors tensors = TensorsOf(network);
  for (const NamedArray& array : snapshot.arrays) {
    const torch::Tensor values =
        torch::from_blob(const_cast<float*>(array.values.data()), array.shape, torch::kFloat32);
    TensorOf(tensors, {array.name, array.shape}).copy_(values);
  }
}

WeightsSnapshot ToSnapshot(const Network& network, std::uint32_t version) {
  const NamedTensors tensors = TensorsOf(network);
  WeightsSnapshot snapshot;
  snapshot.version = version;
  snapshot.description = network->description();
  for (const ArrayShape& array : ArraysOf(snapshot.description)) {
    const torch::Tensor values =
        TensorOf(tensors, array).detach().to(torch::kCPU, torch::kFloat32).contiguous();
    const float* const first = values.data_ptr<float>();
    snapshot.arrays.push_back({array.name, array.shape, {first, first + values.numel()}});
  }
  return snapshot;
}

}  // namespace powderkeg

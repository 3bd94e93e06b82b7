#pragma once

// Module <-> snapshot. Includes Torch: for common/torch and learner/train alone.

#include <cstdint>

#include "common/base/rng.h"
#include "common/model/weights_snapshot.h"
#include "common/torch/torch_network.h"

namespace powderkeg {

// A module in training mode on the CPU with InitialWeights(description, rng).
[[nodiscard]] Network MakeNetwork(const NetworkDescription& description, Rng rng);
// A module in training mode on the CPU with the weights of the snapshot. Throws Error.
[[nodiscard]] Network MakeNetwork(const WeightsSnapshot& snapshot);

// Copies the weights into the module, on whatever device it is. Throws Error if the snapshot is
// invalid or of another description; the module is then unchanged.
void LoadWeights(const WeightsSnapshot& snapshot, Network& network);

// The weights of the module, without a canary; waits for the device.
[[nodiscard]] WeightsSnapshot ToSnapshot(const Network& network, std::uint32_t version);

}  // namespace powderkeg

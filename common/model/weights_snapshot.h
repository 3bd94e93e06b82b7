#pragma once

// Immutable weights of one version, and their form as bytes.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/rng.h"
#include "common/model/evaluator.h"
#include "common/model/network_description.h"

namespace powderkeg {

struct NamedArray {
  std::string name;
  std::vector<std::int64_t> shape;
  std::vector<float> values;  // row-major

  friend bool operator==(const NamedArray&, const NamedArray&) = default;
};

// Positions with the answers that the learner's network gives (fp32): whoever loads the weights
// evaluates them too and refuses the weights if the answers differ by more than its tolerance. All
// three have the same size; evaluated with the default GameSettings and without fog.
struct Canary {
  std::vector<State> states;
  std::vector<AgentId> viewers;
  std::vector<Evaluation> evaluations;

  friend bool operator==(const Canary&, const Canary&) = default;
};

// Immutable once made; share as shared_ptr<const WeightsSnapshot>.
struct WeightsSnapshot {
  std::uint32_t version = 0;
  NetworkDescription description;
  std::vector<NamedArray> arrays;  // in the order of ArraysOf(description)
  Canary canary;

  // Throws Error if missing.
  [[nodiscard]] const NamedArray& Array(std::string_view name) const;

  friend bool operator==(const WeightsSnapshot&, const WeightsSnapshot&) = default;
};

using Snapshot = std::shared_ptr<const WeightsSnapshot>;

enum class Initialisation : std::uint8_t {
  kHe,       // Kaiming-uniform, with small last layers (policy nearly uniform, value near 0)
  kPytorch,  // the default of its layers: uniform within 1 / sqrt(fan_in), biases too
};

// Untrained weights, the same on every machine for equal arguments. Version 0, no canary.
[[nodiscard]] WeightsSnapshot InitialWeights(const NetworkDescription& description, Rng rng,
                                             Initialisation initialisation = Initialisation::kHe);

// Throws Error unless the description is valid, the arrays are those of the description, every
// value is finite and no variance is negative.
void Validate(const WeightsSnapshot& snapshot);

// Self-contained little-endian bytes (format: weights_format.cc), the same in memory, on the
// wire and in a .weights file.
[[nodiscard]] std::vector<std::uint8_t> Serialize(const WeightsSnapshot& snapshot);
// Throws Error that says what is wrong: truncated, bad magic, shapes that do not fit the
// description, a value that is not finite. Safe on untrusted bytes.
[[nodiscard]] WeightsSnapshot Deserialize(std::span<const std::uint8_t> bytes);

// Files appear whole or not at all (temporary, fsync, rename). Both throw Error.
void SaveSnapshot(const WeightsSnapshot& snapshot, const std::string& path);
[[nodiscard]] Snapshot LoadSnapshot(const std::string& path);

// Answers the questions of the canary with `evaluator`. Requires as many viewers as states.
[[nodiscard]] Canary MakeCanary(std::vector<State> states, std::vector<AgentId> viewers,
                                Evaluator& evaluator);

// Largest difference in policy probability and in value over the canary positions.
struct CanaryDifference {
  float policy = 0;  // that of the viewer or a foretold one
  float value = 0;
};
// Infinite where the evaluator's answer is not a number.
[[nodiscard]] CanaryDifference CompareCanary(const WeightsSnapshot& snapshot, Evaluator& evaluator);

}  // namespace powderkeg

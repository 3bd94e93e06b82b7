#include "common/model/weights_snapshot.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/check.h"
#include "common/base/durable_file.h"

namespace powderkeg {
namespace {

void ValidateArray(const NamedArray& array, const ArrayShape& expected) {
  if (array.name != expected.name || array.shape != expected.shape ||
      std::ssize(array.values) != ElementCount(expected.shape)) {
    throw Error(StrCat("weights: array '", array.name, "' with ", array.values.size(),
                       " values does not fit the description, expected '", expected.name, "' with ",
                       ElementCount(expected.shape)));
  }
  const bool is_variance = array.name.ends_with(".running_var");
  for (std::size_t i = 0; i < array.values.size(); ++i) {
    const float value = array.values[i];
    if (!std::isfinite(value) || (is_variance && value < 0.0F)) {
      throw Error(StrCat("weights: ", array.name, "[", i, "] is ", value, ", expected a finite ",
                         is_variance ? "variance" : "number"));
    }
  }
}

std::vector<Evaluation> Answers(const Canary& canary, Evaluator& evaluator) {
  std::vector<Position> positions;
  for (std::size_t i = 0; i < canary.states.size(); ++i) {
    positions.push_back({.state = &canary.states[i], .viewer = canary.viewers[i]});
  }
  std::vector<Evaluation> evaluations(positions.size());
  evaluator.Evaluate(GameSettings{}, positions, evaluations);
  return evaluations;
}

float Distance(float a, float b) {
  const float distance = std::abs(a - b);
  return std::isfinite(distance) ? distance : std::numeric_limits<float>::infinity();
}

}  // namespace

const NamedArray& WeightsSnapshot::Array(std::string_view name) const {
  const auto found = std::ranges::find(arrays, name, &NamedArray::name);
  if (found == arrays.end()) throw Error(StrCat("weights: no array '", name, "'"));
  return *found;
}

void Validate(const WeightsSnapshot& snapshot) {
  Validate(snapshot.description);
  const std::vector<ArrayShape> expected = ArraysOf(snapshot.description);
  if (snapshot.arrays.size() != expected.size()) {
    throw Error(StrCat("weights: ", snapshot.arrays.size(), " arrays, expected ", expected.size()));
  }
  for (std::size_t i = 0; i < expected.size(); ++i) ValidateArray(snapshot.arrays[i], expected[i]);
}

void SaveSnapshot(const WeightsSnapshot& snapshot, const std::string& path) {
  WriteFileDurably(path, Serialize(snapshot));
}

Snapshot LoadSnapshot(const std::string& path) {
  const std::vector<std::uint8_t> bytes = ReadFileBytes(path);
  try {
    return std::make_shared<const WeightsSnapshot>(Deserialize(bytes));
  } catch (const Error& error) {
    throw Error(StrCat(path, ": ", error.what()));
  }
}

Canary MakeCanary(std::vector<State> states, std::vector<AgentId> viewers, Evaluator& evaluator) {
  CHECK(states.size() == viewers.size());
  Canary canary{std::move(states), std::move(viewers), {}};
  canary.evaluations = Answers(canary, evaluator);
  return canary;
}

CanaryDifference CompareCanary(const WeightsSnapshot& snapshot, Evaluator& evaluator) {
  const std::vector<Evaluation> answers = Answers(snapshot.canary, evaluator);
  CanaryDifference largest;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const Evaluation& expected = snapshot.canary.evaluations[i];
    for (std::size_t action = 0; action < kActionCount; ++action) {
      largest.policy =
          std::max(largest.policy, Distance(answers[i].policy[action], expected.policy[action]));
    }
    for (std::size_t other = 0; other < expected.others.size(); ++other) {
      for (std::size_t action = 0; action < kActionCount; ++action) {
        const int distance = int{answers[i].others[other][action]} - expected.others[other][action];
        largest.policy = std::max(largest.policy, static_cast<float>(std::abs(distance)) / 255);
      }
    }
    largest.value = std::max(largest.value, Distance(answers[i].value, expected.value));
  }
  return largest;
}

}  // namespace powderkeg

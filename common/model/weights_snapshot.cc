#include "common/model/weights_snapshot.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "common/base/check.h"

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

[[noreturn]] void ThrowSystemError(const char* what, const std::string& path) {
  const int error = errno;
  throw Error(StrCat("cannot ", what, " ", path, ": ", std::strerror(error)));
}

// A file descriptor that is closed at the end of its scope.
class Descriptor {
 public:
  Descriptor(const std::string& path, int flags) : number_(::open(path.c_str(), flags, 0644)) {
    if (number_ < 0) ThrowSystemError("open", path);
  }
  ~Descriptor() { ::close(number_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

void WriteAndSync(std::span<const std::uint8_t> bytes, const std::string& path) {
  const Descriptor file(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC);
  while (!bytes.empty()) {
    const ssize_t written = ::write(file.number(), bytes.data(), bytes.size());
    if (written < 0 && errno != EINTR) ThrowSystemError("write", path);
    if (written > 0) bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  if (::fsync(file.number()) != 0) ThrowSystemError("sync", path);
}

void SyncFolder(const std::string& path) {
  const Descriptor folder(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (::fsync(folder.number()) != 0) ThrowSystemError("sync", path);
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
  const std::string temporary = StrCat(path, ".", ::getpid(), ".tmp");
  try {
    WriteAndSync(Serialize(snapshot), temporary);
    if (std::rename(temporary.c_str(), path.c_str()) != 0) ThrowSystemError("rename to", path);
  } catch (const Error&) {
    ::unlink(temporary.c_str());
    throw;
  }
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  SyncFolder(folder.empty() ? "." : folder.string());
}

Snapshot LoadSnapshot(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) ThrowSystemError("open", path);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  try {
    return std::make_shared<const WeightsSnapshot>(
        Deserialize({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}));
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
    largest.value = std::max(largest.value, Distance(answers[i].value, expected.value));
  }
  return largest;
}

}  // namespace powderkeg

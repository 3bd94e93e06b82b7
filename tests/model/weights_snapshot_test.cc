#include "common/model/weights_snapshot.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/model/folded_network.h"
#include "tests/model/positions.h"
#include "tests/model/reference_evaluator.h"

namespace powderkeg {
namespace {

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();

// A network so small that every byte of its snapshot can be tried.
NetworkDescription TinyNetwork() {
  NetworkDescription network;
  network.stem_channels = 1;
  network.stem_stride = 2;
  network.blocks = {{BlockDescription::Kind::kInvertedResidual, 2, 1, 2},
                    {BlockDescription::Kind::kResidual, 1, 1, 1}};
  network.value_channels = 1;
  network.value_hidden = 1;
  network.policy_channels = 1;
  return network;
}

WeightsSnapshot TinySnapshot() {
  const Snapshot weights = RandomWeights(TinyNetwork(), 1);
  ReferenceEvaluator evaluator(weights);
  WeightsSnapshot snapshot = *weights;
  snapshot.canary = MakeCanary({BusyState(Rng(1)), BusyState(Rng(2))}, {3, 0}, evaluator);
  return snapshot;
}

// Reads changed bytes; whatever they say, the answer is an Error or a valid snapshot.
bool IsRefused(std::span<const std::uint8_t> bytes) {
  try {
    Validate(Deserialize(bytes));
    return false;
  } catch (const Error&) {
    return true;
  }
}

TEST(WeightsSnapshot, SurvivesItsBytes) {
  const WeightsSnapshot snapshot = TinySnapshot();
  EXPECT_EQ(Deserialize(Serialize(snapshot)), snapshot);
}

TEST(WeightsSnapshot, EveryTruncationIsRefused) {
  const std::vector<std::uint8_t> bytes = Serialize(TinySnapshot());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_TRUE(IsRefused(std::span(bytes).first(size))) << size;
  }
  EXPECT_FALSE(IsRefused(bytes));
}

TEST(WeightsSnapshot, TrailingBytesAreRefused) {
  std::vector<std::uint8_t> bytes = Serialize(TinySnapshot());
  bytes.push_back(0);
  EXPECT_TRUE(IsRefused(bytes));
}

WeightsSnapshot WithoutCanary() {
  WeightsSnapshot snapshot = TinySnapshot();
  snapshot.canary = {};
  return snapshot;
}

// The same in an older format: 2 lacks the description's others_hidden, 1 the checksum too (what is
// wrong must be found by reading).
std::vector<std::uint8_t> InFormat(std::uint8_t format) {
  constexpr std::ptrdiff_t kFormat = 8;
  constexpr std::ptrdiff_t kChecksum = 12;
  constexpr std::ptrdiff_t kChecksummed = 16;
  constexpr std::ptrdiff_t kBlocks = kChecksummed + 4 + 3 * 4 + 4;
  constexpr std::ptrdiff_t kOthersHidden = kBlocks + 2 * (1 + 3 * 4) + 4 * 4;
  std::vector<std::uint8_t> bytes = Serialize(WithoutCanary());
  bytes[kFormat] = format;
  bytes.erase(bytes.begin() + kOthersHidden, bytes.begin() + kOthersHidden + 4);
  const std::uint32_t checksum = Crc32c(std::span(bytes).subspan(kChecksummed));
  std::memcpy(&bytes[kChecksum], &checksum, sizeof(checksum));
  if (format == 1) bytes.erase(bytes.begin() + kChecksum, bytes.begin() + kChecksummed);
  return bytes;
}

TEST(WeightsSnapshot, OlderFormatsAreRead) {
  EXPECT_EQ(Deserialize(InFormat(1)), WithoutCanary());
  EXPECT_EQ(Deserialize(InFormat(2)), WithoutCanary());
}

TEST(WeightsSnapshot, FlippedBitsAreRefused) {
  std::vector<std::uint8_t> bytes = Serialize(TinySnapshot());
  for (std::uint8_t& byte : bytes) {
    for (const int flip : {0x01, 0x80, 0xFF}) {
      const std::uint8_t before = byte;
      byte = static_cast<std::uint8_t>(before ^ flip);
      ASSERT_TRUE(IsRefused(bytes)) << &byte - bytes.data();
      byte = before;
    }
  }
}

TEST(WeightsSnapshot, FlippedBitsWithoutAChecksumNeverGiveAnInvalidSnapshot) {
  std::vector<std::uint8_t> bytes = InFormat(1);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (const int flip : {0x01, 0x80, 0xFF}) {
      const std::uint8_t before = bytes[i];
      bytes[i] = static_cast<std::uint8_t>(before ^ flip);
      const bool refused = IsRefused(bytes);
      if (i < 12) {
        ASSERT_TRUE(refused) << i;  // magic and format
      }
      bytes[i] = before;
    }
  }
}

TEST(WeightsSnapshot, HugeCountsAreRefusedBeforeMemoryIsTaken) {
  std::vector<std::uint8_t> bytes = InFormat(1);
  constexpr std::size_t kStemChannels = 8 + 4 + 4 + 4;
  bytes[kStemChannels + 1] = 0x07;  // 1,793 channels that are not there
  EXPECT_TRUE(IsRefused(bytes));
}

TEST(WeightsSnapshot, ValidationNamesTheArray) {
  WeightsSnapshot snapshot = TinySnapshot();
  snapshot.arrays[2].values[0] = kNotANumber;
  try {
    Validate(snapshot);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("stem.bn.bias[0] is nan"), std::string::npos)
        << error.what();
  }
}

TEST(WeightsSnapshot, RefusesWhatDoesNotFitTheDescription) {
  const WeightsSnapshot good = TinySnapshot();
  WeightsSnapshot other_network = good;
  other_network.description = SmallNetwork();
  EXPECT_THROW(Validate(other_network), Error);
  WeightsSnapshot renamed = good;
  renamed.arrays[0].name = "stem.conv.weights";
  EXPECT_THROW(Validate(renamed), Error);
  WeightsSnapshot short_values = good;
  short_values.arrays[0].values.pop_back();
  EXPECT_THROW(Validate(short_values), Error);
  WeightsSnapshot negative_variance = good;
  negative_variance.arrays[4].values[0] = -1.0F;
  EXPECT_THROW(Validate(negative_variance), Error);
  WeightsSnapshot infinite = good;
  infinite.arrays[0].values[0] = std::numeric_limits<float>::infinity();
  EXPECT_THROW((void)Deserialize(Serialize(infinite)), Error);
}

TEST(WeightsSnapshot, ArrayByName) {
  const WeightsSnapshot snapshot = TinySnapshot();
  EXPECT_EQ(snapshot.Array("stem.bn.weight").shape, (std::vector<std::int64_t>{1}));
  EXPECT_THROW((void)snapshot.Array("stem.bn.beta"), Error);
}

class SnapshotFileTest : public testing::Test {
 protected:
  SnapshotFileTest() { std::filesystem::create_directories(folder_); }
  ~SnapshotFileTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("weights_test_" + std::to_string(getpid()));
};

TEST_F(SnapshotFileTest, SavesAndLoadsAndLeavesNothingElse) {
  const WeightsSnapshot snapshot = TinySnapshot();
  const std::string path = folder_ / "a.weights";
  SaveSnapshot(snapshot, path);
  SaveSnapshot(snapshot, path);
  EXPECT_EQ(*LoadSnapshot(path), snapshot);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1);
}

TEST_F(SnapshotFileTest, ErrorsNameTheFile) {
  const std::string path = folder_ / "b.weights";
  EXPECT_THROW((void)LoadSnapshot(path), Error);
  EXPECT_THROW(SaveSnapshot(TinySnapshot(), folder_ / "absent" / "b.weights"), Error);
  std::ofstream(path) << "no weights";
  try {
    (void)LoadSnapshot(path);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
  }
}

// Answers as the reference with one thing wrong.
class WrongEvaluator final : public Evaluator {
 public:
  WrongEvaluator(Snapshot snapshot, float policy_error, float value_error)
      : reference_(std::move(snapshot)), policy_error_(policy_error), value_error_(value_error) {}
  void Evaluate(const GameSettings& settings, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    reference_.Evaluate(settings, positions, evaluations);
    evaluations.back().policy[4] += policy_error_;
    evaluations.back().value += value_error_;
  }
  [[nodiscard]] std::string name() const override { return "wrong"; }

 private:
  ReferenceEvaluator reference_;
  float policy_error_;
  float value_error_;
};

TEST(Canary, TellsHowFarAnEvaluatorIsOff) {
  const auto snapshot = std::make_shared<const WeightsSnapshot>(TinySnapshot());
  WrongEvaluator same(snapshot, 0.0F, 0.0F);
  EXPECT_EQ(CompareCanary(*snapshot, same).policy, 0.0F);
  EXPECT_EQ(CompareCanary(*snapshot, same).value, 0.0F);
  WrongEvaluator off(snapshot, 0.25F, -0.5F);
  EXPECT_NEAR(CompareCanary(*snapshot, off).policy, 0.25F, 1e-6F);
  EXPECT_NEAR(CompareCanary(*snapshot, off).value, 0.5F, 1e-6F);
}

TEST(Canary, AnswersThatAreNotNumbersAreInfinitelyFarOff) {
  const auto snapshot = std::make_shared<const WeightsSnapshot>(TinySnapshot());
  WrongEvaluator broken(snapshot, kNotANumber, kNotANumber);
  EXPECT_TRUE(std::isinf(CompareCanary(*snapshot, broken).policy));
  EXPECT_TRUE(std::isinf(CompareCanary(*snapshot, broken).value));
}

TEST(InitialWeights, AreDeterministicAndNearlyUniform) {
  const WeightsSnapshot snapshot = InitialWeights(SmallNetwork(), Rng(1));
  EXPECT_EQ(snapshot, InitialWeights(SmallNetwork(), Rng(1)));
  EXPECT_FALSE(snapshot == InitialWeights(SmallNetwork(), Rng(2)));
  ReferenceEvaluator evaluator(std::make_shared<const WeightsSnapshot>(snapshot));
  const std::vector<State> states = PlayedStates(5, 1);
  for (const Evaluation& evaluation : EvaluateAll(evaluator, PositionsOf(states))) {
    for (const float probability : evaluation.policy) EXPECT_NEAR(probability, 1.0 / 6.0, 0.08);
    EXPECT_NEAR(evaluation.value, 0.0, 0.3);
  }
}

TEST(InitialWeights, OfPytorchAreUniformWithinTheRootOfTheFanIn) {
  const WeightsSnapshot snapshot = InitialWeights(PaperNetwork(), Rng(1), Initialisation::kPytorch);
  const auto largest = [&](const char* name) {
    float most = 0;
    for (const float value : snapshot.Array(name).values) most = std::max(most, std::abs(value));
    return most;
  };
  EXPECT_NEAR(largest("policy.fc.weight"), 1 / std::sqrt(576.0), 0.001);
  EXPECT_NEAR(largest("policy.fc.bias"), 1 / std::sqrt(576.0), 0.02);
  EXPECT_GT(largest("policy.fc.bias"), 0);
  EXPECT_EQ(largest("stem.bn.bias"), 0);
  EXPECT_EQ(largest("stem.bn.weight"), 1);
}

TEST(InitialWeights, PinnedOnEveryMachine) {
  const WeightsSnapshot snapshot = InitialWeights(PaperNetwork(), Rng(1));
  const std::vector<float>& stem = snapshot.Array("stem.conv.weight").values;
  EXPECT_EQ(stem.front(), -0.148370072F);
  EXPECT_EQ(stem.back(), -0.0445583574F);
}

}  // namespace
}  // namespace powderkeg

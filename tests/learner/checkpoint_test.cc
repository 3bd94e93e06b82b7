#include "learner/train/checkpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "common/base/check.h"
#include "common/base/durable_file.h"
#include "tests/learner/record_support.h"

namespace powderkeg {
namespace {

namespace fs = std::filesystem;

Checkpoint CheckpointOf(int iteration) {
  Checkpoint checkpoint;
  for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(iteration); ++i) {
    checkpoint.data_sets.push_back({10 * i, 10 * i + 9});
  }
  TrainerState& trainer = checkpoint.trainer;
  trainer.weights = InitialWeights(SmallNetwork(), Rng(3));
  trainer.weights.version = static_cast<std::uint32_t>(iteration) + 1;
  trainer.optimizer = {{"stem.conv.weight.exp_avg", {2, 3}, {1, 2, 3, 4, 5, 6}},
                       {"stem.bn.bias.exp_avg", {1}, {-0.5F}}};
  trainer.optimizer_steps = 1234;
  trainer.samples_seen = 567'890;
  checkpoint.table = "iteration,games\n1,2\n";
  return checkpoint;
}

fs::path PathOf(const fs::path& folder, int iteration) {
  return folder / StrCat("iteration-0000000", iteration, ".checkpoint");
}

TEST(Checkpoint, RoundTrip) {
  EXPECT_EQ(DeserializeCheckpoint(Serialize(CheckpointOf(3))), CheckpointOf(3));
  EXPECT_EQ(DeserializeCheckpoint(Serialize(CheckpointOf(0))), CheckpointOf(0));
}

TEST(Checkpoint, DamagedBytesAreRefused) {
  const std::vector<std::uint8_t> whole = Serialize(CheckpointOf(2));
  Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    std::vector<std::uint8_t> bytes = whole;
    bytes[rng.Below(static_cast<std::uint32_t>(bytes.size()))] ^=
        static_cast<std::uint8_t>(1 + rng.Below(255));
    EXPECT_THROW((void)DeserializeCheckpoint(bytes), Error);
    bytes = whole;
    bytes.resize(rng.Below(static_cast<std::uint32_t>(bytes.size())));
    EXPECT_THROW((void)DeserializeCheckpoint(bytes), Error);
  }
  std::vector<std::uint8_t> longer = whole;
  longer.push_back(0);
  EXPECT_THROW((void)DeserializeCheckpoint(longer), Error);
}

TEST(Checkpoint, DataSetsWithAGapAreRefused) {
  Checkpoint checkpoint = CheckpointOf(2);
  checkpoint.data_sets[1].first += 1;
  EXPECT_THROW((void)DeserializeCheckpoint(Serialize(checkpoint)), Error);
}

TEST(CheckpointFolder, LoadsTheNewestAndKeepsAsManyAsAsked) {
  const TemporaryFolder folder;
  CheckpointFolder checkpoints(folder.path() / "checkpoints", 2);
  EXPECT_EQ(checkpoints.LoadNewest(), std::nullopt);
  for (const int iteration : {1, 2, 3}) checkpoints.Save(CheckpointOf(iteration));
  EXPECT_EQ(checkpoints.LoadNewest(), CheckpointOf(3));
  EXPECT_FALSE(fs::exists(PathOf(folder.path() / "checkpoints", 1)));
  EXPECT_TRUE(fs::exists(PathOf(folder.path() / "checkpoints", 2)));
}

TEST(CheckpointFolder, DamagedOnesAreSkippedAndGoWithTheNextSave) {
  const TemporaryFolder folder;
  CheckpointFolder checkpoints(folder.path(), 3);
  for (const int iteration : {1, 2, 3}) checkpoints.Save(CheckpointOf(iteration));
  fs::resize_file(PathOf(folder.path(), 3), fs::file_size(PathOf(folder.path(), 3)) / 2);
  EXPECT_EQ(checkpoints.LoadNewest(), CheckpointOf(2));
  fs::resize_file(PathOf(folder.path(), 2), 0);
  EXPECT_EQ(checkpoints.LoadNewest(), CheckpointOf(1));
  checkpoints.Save(CheckpointOf(2));
  EXPECT_EQ(checkpoints.LoadNewest(), CheckpointOf(2));
  EXPECT_FALSE(fs::exists(PathOf(folder.path(), 3)));
}

TEST(CheckpointFolder, IfAllAreDamagedThatIsAnError) {
  const TemporaryFolder folder;
  CheckpointFolder checkpoints(folder.path(), 3);
  for (const int iteration : {1, 2}) {
    checkpoints.Save(CheckpointOf(iteration));
    fs::resize_file(PathOf(folder.path(), iteration), 100);
  }
  EXPECT_THROW((void)checkpoints.LoadNewest(), Error);
}

TEST(CheckpointFolder, AStaleTemporaryIsNoCheckpoint) {
  const TemporaryFolder folder;
  CheckpointFolder(folder.path(), 3).Save(CheckpointOf(1));
  const fs::path stale = PathOf(folder.path(), 2).string() + std::string(kTemporaryEnding);
  std::ofstream(stale) << "half";
  EXPECT_EQ(CheckpointFolder(folder.path(), 3).LoadNewest(), CheckpointOf(1));
  EXPECT_FALSE(fs::exists(stale));
}

}  // namespace
}  // namespace powderkeg

#include "common/base/processors.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <thread>

namespace powderkeg {
namespace {

namespace fs = std::filesystem;

class UsableProcessorsTest : public testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder_); }

  // A control group's quota; "" stands for the one that all are in.
  void Write(const std::string& group, const std::string& text) {
    fs::create_directories(folder_ / group);
    std::ofstream(folder_ / group / "cpu.max") << text << "\n";
  }
  [[nodiscard]] int Usable(const std::string& own) {
    fs::create_directories(folder_);
    std::ofstream(folder_ / "own") << own << "\n";
    return UsableProcessors(folder_, folder_ / "own");
  }

  const int all_ = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const fs::path folder_ = fs::path(testing::TempDir()) / "pk-control-groups";
};

TEST_F(UsableProcessorsTest, WithoutAQuotaThereAreAllOfThem) {
  EXPECT_EQ(UsableProcessors("/nowhere", "/nowhere"), all_);
  Write("service", "max 100000");
  EXPECT_EQ(Usable("0::/service"), all_);
  EXPECT_EQ(Usable("4:cpu:/service"), all_);
  Write("service", "nonsense");
  EXPECT_EQ(Usable("0::/service"), all_);
}

TEST_F(UsableProcessorsTest, ThoseThatItMayNotRunOnDoNotCount) {
  cpu_set_t before;
  ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(sched_getcpu(), &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  EXPECT_EQ(UsableProcessors("/nowhere", "/nowhere"), 1);
  ASSERT_EQ(sched_setaffinity(0, sizeof before, &before), 0);
}

TEST_F(UsableProcessorsTest, TheSmallestQuotaOfTheGroupsAboveHolds) {
  Write("", "100000000 100000");
  Write("machine", "100000 100000");
  Write("machine/one", "max 100000");
  EXPECT_EQ(Usable("0::/machine/one"), 1);
  EXPECT_EQ(Usable("0::/other"), all_);
}

TEST_F(UsableProcessorsTest, ItIsRoundedUpAndNeverMoreThanThereAre) {
  Write("container", "20000 100000");
  EXPECT_EQ(Usable("0::/container"), 1);
  Write("container", "110000 100000");
  EXPECT_EQ(Usable("0::/container"), std::min(2, all_));
}

// Where it sees no other groups than its own.
TEST_F(UsableProcessorsTest, AContainersGroupIsTheFirst) {
  Write("", "50000 100000");
  EXPECT_EQ(Usable("0::/"), 1);
}

}  // namespace
}  // namespace powderkeg

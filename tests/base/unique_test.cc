#include "common/base/unique.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <set>
#include <stdexcept>

namespace powderkeg {
namespace {

std::uint32_t Throw() { throw std::runtime_error("no entropy"); }
std::uint32_t Constant() { return 7; }

TEST(UniqueNumberTest, NoTwoAreTheSameWhateverTheDevice) {
  std::set<std::uint64_t> numbers;
  for (int i = 0; i < 100; ++i) {
    numbers.insert(UniqueNumber());
    numbers.insert(UniqueNumber(Constant));
    numbers.insert(UniqueNumber(Throw));
  }
  EXPECT_EQ(numbers.size(), 300u);
}

TEST(UniqueNumberTest, TwoProcessesDrawDifferentNumbersFromAConstantDevice) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const std::uint64_t number = UniqueNumber(Constant);
    _exit(write(ends[1], &number, sizeof number) == sizeof number ? 0 : 1);
  }
  const std::uint64_t mine = UniqueNumber(Constant);
  std::uint64_t other = mine;
  ASSERT_EQ(read(ends[0], &other, sizeof other), static_cast<ssize_t>(sizeof other));
  EXPECT_NE(mine, other);
  waitpid(child, nullptr, 0);
  for (const int end : ends) close(end);
}

TEST(UniqueNumberTest, ADeviceThatFailsIsSaid) {
  testing::internal::CaptureStderr();
  (void)UniqueNumber(Throw);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("reason=\"no entropy\""),
            std::string::npos);
}

}  // namespace
}  // namespace powderkeg

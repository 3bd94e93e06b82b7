#include "learner/run/run_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <fstream>
#include <string>
#include <vector>

#include "common/base/check.h"
#include "tests/learner/record_support.h"

namespace {

int lock_error = 0;  // what flock answers

}  // namespace

// Stands before the system's function for this whole program.
extern "C" int flock(int file, int operation) noexcept {
  if (lock_error == 0) return static_cast<int>(syscall(SYS_flock, file, operation));
  errno = lock_error;
  return -1;
}

namespace powderkeg {
namespace {

using std::chrono::milliseconds;

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::MatchesRegex;

template <typename Action>
std::string MessageOf(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(RunLock, AFolderHasOneOwnerAtATime) {
  const TemporaryFolder folder;
  {
    const RunLock lock(folder.path());
    EXPECT_EQ(MessageOf([&] { RunLock{folder.path()}; }),
              folder.path().string() + " is in use by another learner");
  }
  EXPECT_EQ(MessageOf([&] { RunLock{folder.path()}; }), "no error");
}

TEST(RunLock, AFileSystemWithoutLocksIsSaidAndUsed) {
  const TemporaryFolder folder;
  for (const int error : {ENOLCK, ENOTSUP, ENOSYS}) {
    lock_error = error;
    testing::internal::CaptureStderr();
    EXPECT_EQ(MessageOf([&] { RunLock{folder.path()}; }), "no error");
    EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("has no locks"));
  }
  lock_error = EIO;
  EXPECT_THAT(MessageOf([&] { RunLock{folder.path()}; }), HasSubstr("cannot lock"));
  lock_error = 0;
}

TEST(RunClaim, ASecondLearnerIsNoticed) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "learner.claim";
  {
    const RunClaim first(file, milliseconds(20));
    EXPECT_THAT(MessageOf([&] { RunClaim(file, milliseconds(100)); }),
                HasSubstr(folder.path().string() + " is in use by another learner: "));
  }
  EXPECT_FALSE(fs::exists(file));
  EXPECT_EQ(MessageOf([&] { RunClaim(file, milliseconds(100)); }), "no error");
}

TEST(RunClaim, WhatNobodyRenewsIsTakenOver) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "learner.claim";
  for (const char* claim : {"elsewhere 1 2 3", "nonsense", ""}) {
    std::ofstream(file) << claim << '\n';
    EXPECT_EQ(MessageOf([&] { RunClaim(file, milliseconds(10)); }), "no error") << claim;
  }
}

TEST(RunLock, SaysWhichFileItCannotMake) {
  EXPECT_THAT(MessageOf([] { RunLock{"/absent/run"}; }),
              HasSubstr("cannot create /absent/run/learner.lock: "));
}

TEST(RunName, IsTheFolders) {
  EXPECT_EQ(RunNameOf("runs/first-run"), "first-run");
  EXPECT_EQ(RunNameOf("runs/first-run/"), "first-run");
  EXPECT_EQ(RunNameOf("runs/old/../first-run"), "first-run");
  EXPECT_EQ(RunNameOf("."), fs::current_path().filename().string());
  for (const char* const folder : {"runs/..", "runs/.", "..", "runs/my run", ""}) {
    EXPECT_THAT(MessageOf([&] { static_cast<void>(RunNameOf(folder)); }),
                HasSubstr("expected 1 to 64 letters"))
        << folder;
  }
}

TEST(RunId, IsMadeOnceAndOtherwiseInAnotherFolder) {
  const TemporaryFolder parent;
  fs::create_directories(parent.path() / "a/run");
  fs::create_directories(parent.path() / "b/run");
  const std::string id = RunIdOf(parent.path() / "a/run");
  EXPECT_THAT(id, MatchesRegex("run-[0-9a-f]+"));
  EXPECT_EQ(RunIdOf(parent.path() / "a/run"), id);
  EXPECT_NE(RunIdOf(parent.path() / "b/run"), id);
}

TEST(ConfigOfRun, IsTheStoredOneUnlessAFileIsGiven) {
  const TemporaryFolder folder;
  const std::vector<std::string> none;
  EXPECT_EQ(ConfigOfRun(folder.path(), "", none).training.batch_size,
            RunConfig().training.batch_size);

  const std::vector<std::string> changes = {"training.batch_size=77", "training.iterations=3"};
  StoreConfig(folder.path(), ConfigOfRun(folder.path(), "", changes));
  const RunConfig stored = ConfigOfRun(folder.path(), "", none);
  EXPECT_EQ(stored.training.batch_size, 77);
  EXPECT_EQ(stored.training.iterations, 3);

  const std::string file = (folder.path() / "other.textproto").string();
  std::ofstream(file) << "training { batch_size: 5 }\n";
  EXPECT_EQ(ConfigOfRun(folder.path(), file, none).training.batch_size, 5);
  EXPECT_EQ(ConfigOfRun(folder.path(), file, none).training.iterations,
            RunConfig().training.iterations);
}

TEST(ConfigOfRun, KeepsWhatGamesAndWeightsAreOf) {
  const TemporaryFolder folder;
  StoreConfig(folder.path(), RunConfig());
  const auto changed = [&](const std::string& change) {
    const std::vector<std::string> changes = {change};
    return MessageOf([&] { CheckRun(folder.path(), "", changes); });
  };
  for (const char* const change :
       {"self_play.games_in_flight=7", "self_play.search.simulations=9", "training.epochs=3",
        "training.network=small", "self_play.environment=PommeFFACompetition-v0"}) {
    EXPECT_EQ(changed(change), "no error");
  }
  EXPECT_EQ(changed("self_play.environment=PommeTeamCompetition-v0"),
            "self_play.environment is PommeTeamCompetition-v0, but this run began with "
            "PommeFFACompetition-v0; expected a new run, or the same environment, "
            "board_generator, corners, network: the other settings may change");
  EXPECT_THAT(changed("self_play.environment=OneVsOne-v0"), HasSubstr("this run began with"));
  EXPECT_THAT(changed("self_play.board_generator=uniform"), HasSubstr("began with official;"));
  EXPECT_THAT(changed("training.network=paper"), HasSubstr("training.network is paper"));
}

}  // namespace
}  // namespace powderkeg

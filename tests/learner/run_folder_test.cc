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
#include "common/base/durable_file.h"
#include "common/model/weights_snapshot.h"
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

TEST(CheckRun, RefusesANetworkThatCannotBe) {
  const TemporaryFolder folder;
  const auto check = [&](const std::string& network) {
    const std::vector<std::string> changes = {"training.network=" + network};
    return MessageOf([&] { CheckRun(folder.path(), "", changes); });
  };
  EXPECT_EQ(check("stem32+residual32x3"), "no error");
  EXPECT_THAT(check("large"), HasSubstr("unknown network 'large'"));
  EXPECT_THAT(check("stem32+residul32"), HasSubstr("\"residul32\""));
}

// ---- Files that a run keeps ---------------------------------------------------------------------

constexpr char kFreeForAll[] = "PommeFFACompetition-v0";

std::string TextOf(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::string> TextsOf(const std::vector<fs::path>& files) {
  std::vector<std::string> texts;
  for (const fs::path& file : files) texts.push_back(TextOf(file));
  return texts;
}

TEST(DemonstrationsOfRun, AreCopiesFromItsBeginningOn) {
  const TemporaryFolder run, other;
  EXPECT_TRUE(DemonstrationsOfRun(run.path(), {}).empty());
  std::vector<fs::path> given;
  for (const std::string name : {"b", "a", "a/b", "c"}) {  // in the order in which they are given
    const fs::path file = other.path() / (name.size() > 1 ? "folder/b" : name);
    fs::create_directories(file.parent_path());
    std::ofstream(file) << "games of " << name;
    given.push_back(file);
  }
  const std::vector<std::string> texts = {"games of b", "games of a", "games of a/b", "games of c"};
  EXPECT_EQ(TextsOf(DemonstrationsOfRun(run.path(), std::span(given).last(1))).size(), 1u);
  EXPECT_EQ(TextsOf(DemonstrationsOfRun(run.path(), given)), texts) << "the run had not begun";
  StoreConfig(run.path(), RunConfig());
  std::ofstream(given[0]) << "changed";
  fs::remove(given[1]);
  EXPECT_EQ(TextsOf(DemonstrationsOfRun(run.path(), given)), texts);
  EXPECT_EQ(TextsOf(DemonstrationsOfRun(run.path(), {})), texts);
}

TEST(DemonstrationsOfRun, AreRefusedByARunThatBeganWithout) {
  const TemporaryFolder folder;
  StoreConfig(folder.path(), RunConfig());
  const std::vector<fs::path> given = {"tests/data/ffa.jsonl.gz"};
  const std::string reason = "it began without; expected a new run, or none";
  EXPECT_THAT(MessageOf([&] { (void)DemonstrationsOfRun(folder.path(), given); }),
              HasSubstr(reason));
  EXPECT_THAT(MessageOf([&] { CheckDemonstrations(folder.path(), given, kFreeForAll); }),
              HasSubstr(reason));
}

TEST(CheckDemonstrations, ReadsThemAndWritesNothing) {
  const TemporaryFolder folder;
  const auto checked = [&](const fs::path& file) {
    return MessageOf([&] { CheckDemonstrations(folder.path(), {&file, 1}, kFreeForAll); });
  };
  EXPECT_EQ(checked("tests/data/ffa.jsonl.gz"), "no error");
  EXPECT_THAT(checked("tests/data/team.jsonl.gz"), HasSubstr("is of PommeTeamCompetition-v0"));
  EXPECT_THAT(checked("nothing.jsonl"), HasSubstr("cannot open nothing.jsonl; expected"));
  EXPECT_TRUE(FilesIn(folder.path()).empty());
}

// Whatever became of the file: other weights under its name must not get into the run.
TEST(WeightsOfPlayer, AreACopyFromTheRunsBeginningOn) {
  const TemporaryFolder run, other;
  const std::string file = (other.path() / "strong.weights").string();
  const Player player{
      .name = "strong", .weights = PlayerSpec::Weights::kFile, .weights_file = file};
  const auto save = [&](std::uint64_t seed) {
    SaveSnapshot(InitialWeights(NetworkByName("small"), Rng(seed)), file);
  };
  const auto kept = [&] { return *LoadSnapshot(WeightsOfPlayer(run.path(), player).string()); };
  save(1);
  (void)kept();
  save(2);
  const WeightsSnapshot begun = kept();
  EXPECT_EQ(begun, *LoadSnapshot(file)) << "a start that failed is no beginning";
  StoreConfig(run.path(), RunConfig());
  save(3);
  EXPECT_EQ(kept(), begun) << "the file has changed";
  fs::remove(file);
  EXPECT_EQ(kept(), begun) << "the file is gone";
  Player renamed = player;
  renamed.weights_file = (other.path() / "stronger.weights").string();
  EXPECT_THAT(MessageOf([&] { (void)WeightsOfPlayer(run.path(), renamed); }),
              HasSubstr("stronger.weights"));
}

}  // namespace
}  // namespace powderkeg

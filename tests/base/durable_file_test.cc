#include "common/base/durable_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <string>

#include "common/base/check.h"
#include "common/base/digest.h"

namespace {

int folder_error = 0;  // what fsync answers for folders

}  // namespace

// Stands before the system's function for this whole program.
extern "C" int fsync(int file) {
  struct stat status {};
  if (folder_error != 0 && fstat(file, &status) == 0 && S_ISDIR(status.st_mode)) {
    errno = folder_error;
    return -1;
  }
  return static_cast<int>(syscall(SYS_fsync, file));
}

namespace powderkeg {
namespace {

namespace fs = std::filesystem;

class DurableFileTest : public testing::Test {
 protected:
  DurableFileTest() { fs::create_directories(folder_); }
  ~DurableFileTest() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string Contents() const {
    const std::vector<std::uint8_t> bytes = ReadFileBytes(path_);
    return {bytes.begin(), bytes.end()};
  }

  const fs::path folder_ = fs::path(testing::TempDir()) / StrCat("durable_file_test_", getpid());
  const fs::path path_ = folder_ / "file";
};

TEST_F(DurableFileTest, ReplacesAFileAndLeavesNothingElse) {
  WriteFileDurably(path_, BytesOf("first"));
  const std::string second(3'000'000, 'x');  // more than is read at once
  WriteFileDurably(path_, BytesOf(second));
  EXPECT_EQ(Contents(), second);
  EXPECT_EQ(FilesIn(folder_), std::vector<fs::path>{path_});
  WriteFileDurably(path_, {});
  EXPECT_EQ(Contents(), "");
}

// Half a file would keep a full disk full.
TEST_F(DurableFileTest, AFullDiskIsAnErrorThatLeavesTheOldFileAlone) {
  WriteFileDurably(path_, BytesOf("first"));
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};
    setrlimit(RLIMIT_FSIZE, &limit);
    try {
      WriteFileDurably(path_, BytesOf(std::string(3000, 'x')));
    } catch (const Error&) {
      _exit(0);
    }
    _exit(1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_EQ(Contents(), "first");
  EXPECT_EQ(FilesIn(folder_), std::vector<fs::path>{path_}) << "half a file is left";
}

// Some network, FUSE and WSL file systems.
TEST_F(DurableFileTest, AFileSystemThatFlushesNoFoldersIsSaidOnceAndUsed) {
  testing::internal::CaptureStderr();
  for (const int error : {EINVAL, ENOTSUP, ENOSYS}) {
    folder_error = error;
    WriteFileDurably(path_, BytesOf(StrCat(error)));
    EXPECT_EQ(Contents(), StrCat(error));
  }
  folder_error = EIO;
  EXPECT_THROW(SyncFolder(folder_), Error);
  folder_error = 0;
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("flushes no folders"), std::string::npos) << log;
  EXPECT_EQ(std::ranges::count(log, '\n'), 1) << log;
}

TEST_F(DurableFileTest, WhatCannotBeReadIsAnError) {
  EXPECT_THROW((void)ReadFileBytes(path_), Error);
  EXPECT_THROW((void)ReadFileBytes(folder_), Error) << "a folder";
  EXPECT_THROW((void)FilesIn(path_), Error);
}

TEST_F(DurableFileTest, PreparingAFolderDeletesTemporaries) {
  WriteFileDurably(path_, BytesOf("mine"));
  WriteFileDurably(folder_ / "half.tmp", BytesOf("half"));
  PrepareFolder(folder_);
  EXPECT_EQ(FilesIn(folder_), std::vector<fs::path>{path_});
  EXPECT_THROW(PrepareFolder(path_), Error);
}

}  // namespace
}  // namespace powderkeg

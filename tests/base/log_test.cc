#include "common/base/log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "common/base/check.h"

namespace powderkeg {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

std::string ReadAll(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

class LogTest : public testing::Test {
 protected:
  void TearDown() override {
    log::Init("", log::Level::kInfo);
    std::filesystem::remove(path_);
  }
  const std::filesystem::path path_ =
      std::filesystem::path(testing::TempDir()) /
      StrCat(testing::UnitTest::GetInstance()->current_test_info()->name(), ".log");
};

TEST_F(LogTest, WritesMessageAndFields) {
  log::Init(path_, log::Level::kInfo);
  log::Info("actor connected", "name", "node-7", "loops", 4, "share", 0.5);
  EXPECT_THAT(ReadAll(path_), EndsWith(" I actor connected name=node-7 loops=4 share=0.5\n"));
}

TEST_F(LogTest, LeavesOutWhatIsBelowTheLevel) {
  log::Init(path_, log::Level::kWarn);
  log::Info("small");
  log::Warn("large");
  EXPECT_THAT(ReadAll(path_), HasSubstr("large"));
  EXPECT_THAT(ReadAll(path_), Not(HasSubstr("small")));
}

TEST_F(LogTest, QuotesAndCleansWhatAPeerSent) {
  std::string line = "refused";
  log::AppendField(line, "reason", "two words \"quoted\"\nnew line");
  log::AppendField(line, "empty", "");
  EXPECT_EQ(line, R"(refused reason="two words \"quoted\"?new line" empty="")");
}

TEST_F(LogTest, FormatCharactersAreNotInterpreted) {
  log::Init(path_, log::Level::kInfo);
  log::Info("100 % {} %s", "value", "{0}");
  EXPECT_THAT(ReadAll(path_), EndsWith("100 % {} %s value={0}\n"));
}

TEST_F(LogTest, AFileDoesNotGrowWithoutEnd) {
  log::Init(path_, log::Level::kInfo, log::Level::kError);
  const std::string line(std::size_t{1} << 20, 'x');
  for (std::size_t size = 0; size < log::kMaxFileBytes + 3 * line.size(); size += line.size()) {
    log::Info(line);
  }
  std::filesystem::path older = path_;
  older.replace_extension(".1.log");
  EXPECT_LE(std::filesystem::file_size(path_), 5 * line.size());
  EXPECT_LE(std::filesystem::file_size(older), log::kMaxFileBytes);
  std::filesystem::remove(older);
}

TEST_F(LogTest, AFileThatCannotBeOpenedIsAnError) {
  EXPECT_THROW(log::Init("/proc/none/x.log", log::Level::kInfo), Error);
  EXPECT_THROW((void)log::LevelFor("loud"), Error);
  EXPECT_EQ(log::LevelFor("warn"), log::Level::kWarn);
}

}  // namespace
}  // namespace powderkeg

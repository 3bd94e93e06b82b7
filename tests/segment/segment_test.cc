#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/segment/segment_columns.h"
#include "common/segment/segment_file.h"
#include "tests/learner/record_support.h"

namespace powderkeg {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;

std::string MessageOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

void Write(const fs::path& path, std::span<const std::uint8_t> bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), std::ssize(bytes));
}

std::vector<GameRecord> Read(const fs::path& path) {
  std::vector<GameRecord> games;
  ReadSegment(path, [&](GameRecord&& game) { games.push_back(std::move(game)); });
  return games;
}

TEST(SegmentTest, GivesBackTheGames) {
  const TemporaryFolder folder;
  const std::vector<GameRecord> games = RandomRecords(0, 20);
  Write(folder.path() / "x.h5", EncodeSegment(games));
  EXPECT_EQ(Read(folder.path() / "x.h5"), games);
}

TEST(SegmentTest, AMissingFileAndAnotherKindOfFileAreErrorsThatNameIt) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.h5";
  EXPECT_THAT(MessageOf([&] { Read(path); }), AllOf(HasSubstr(path), HasSubstr("No such file")));
  Write(path, BytesOf("not HDF5"));
  EXPECT_THAT(MessageOf([&] { Read(path); }),
              AllOf(HasSubstr(path), HasSubstr("file signature not found")));
}

TEST(SegmentTest, ASegmentCutShortIsAnErrorThatNamesIt) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.h5";
  const std::vector<std::uint8_t> whole = EncodeSegment(RandomRecords(0, 20));
  for (std::size_t size = 0; size < whole.size(); size += 1 + whole.size() / 50) {
    Write(path, std::span(whole).first(size));
    ASSERT_THAT(MessageOf([&] { Read(path); }),
                AllOf(HasSubstr(path), HasSubstr(StrCat(size, " bytes")),
                      AnyOf(HasSubstr("truncated file"), HasSubstr("file signature not found"))));
  }
}

// As a Python that has opened it for writing does.
TEST(SegmentTest, ALockOfAnotherProgramDoesNotMatter) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.h5";
  const std::vector<GameRecord> games = RandomRecords(0, 3);
  Write(path, EncodeSegment(games));
  const int file = open(path.c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_EQ(flock(file, LOCK_EX | LOCK_NB), 0);
  EXPECT_EQ(Read(path), games);
  EXPECT_EQ(ReadTickets(path).size(), games.size());
  close(file);
}

TEST(SegmentTest, FlippedBytesNeverCrash) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.h5";
  const std::vector<std::uint8_t> whole = EncodeSegment(RandomRecords(0, 3));
  Rng rng(5);
  for (int i = 0; i < 200; ++i) {
    std::vector<std::uint8_t> bytes = whole;
    bytes[rng.Below(static_cast<std::uint32_t>(bytes.size()))] ^=
        static_cast<std::uint8_t>(1 + rng.Below(255));
    Write(path, bytes);
    MessageOf([&] { Read(path); });
  }
}

TEST(SegmentTest, ValuesOutOfRangeAreRefused) {
  const SegmentColumns whole = ToColumns(RandomRecords(0, 8));
  const auto reason = [&](auto&& damage) {
    SegmentColumns columns = whole;
    damage(columns);
    return MessageOf([&] { ForEachGame(columns, [](GameRecord&&) {}); });
  };
  EXPECT_EQ(reason([](SegmentColumns&) {}), "no error");
  EXPECT_THAT(reason([](auto& c) { c.games.mode[0] = 0; }), HasSubstr("mode"));
  EXPECT_THAT(reason([](auto& c) { c.games.result[0] = 3; }), HasSubstr("result"));
  EXPECT_THAT(reason([](auto& c) { c.games.seat_policy[0][2] = 5; }), HasSubstr("seat_policy"));
  EXPECT_THAT(reason([](auto& c) { c.games.evaluator[0] = 2; }), HasSubstr("evaluator"));
  EXPECT_THAT(reason([](auto& c) { c.games.seed.pop_back(); }), HasSubstr("games/seed has 7 rows"));
  EXPECT_THAT(reason([](auto& c) { c.games.step_count[7] += 1; }), HasSubstr("ends within"));
  EXPECT_THAT(reason([](auto& c) { c.games.step_count[7] -= 1; }), HasSubstr("goes on"));
  EXPECT_THAT(reason([](auto& c) { c.games.decision_count[1][0] += 1; }),
              HasSubstr("out of order"));
  EXPECT_THAT(reason([](auto& c) { c.steps.actions[0] = 6; }), HasSubstr("action above 5"));
  EXPECT_THAT(reason([](auto& c) { c.decisions.agent[0] = 4; }), HasSubstr("out of order"));
  EXPECT_THAT(reason([](auto& c) { c.games.seat_teaches[0][1] = 3; }), HasSubstr("seat_teaches"));
}

}  // namespace
}  // namespace powderkeg

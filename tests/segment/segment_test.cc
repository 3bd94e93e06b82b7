#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/segment/segment_columns.h"
#include "common/segment/segment_file.h"
#include "common/segment/segment_index.h"
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
  const SegmentDamage damage =
      ReadSegment(path, [&](GameRecord&& game) { games.push_back(std::move(game)); });
  EXPECT_EQ(damage.reason, "");
  return games;
}

SegmentDamage DamageOf(const fs::path& path) {
  return ReadSegment(path, [](GameRecord&&) {});
}

TEST(SegmentTest, GivesBackTheGames) {
  const TemporaryFolder folder;
  const std::vector<GameRecord> games = RandomRecords(0, 20);
  Write(folder.path() / "x.h5", EncodeSegment(games));
  EXPECT_EQ(Read(folder.path() / "x.h5"), games);
}

TEST(SegmentTest, AMissingFileIsAnErrorThatNamesIt) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.h5";
  EXPECT_THAT(MessageOf([&] { Read(path); }), AllOf(HasSubstr(path), HasSubstr("No such file")));
}

TEST(SegmentTest, AnotherKindOfFileIsDamaged) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.h5";
  Write(path, BytesOf("not HDF5"));
  EXPECT_THAT(DamageOf(path).reason, HasSubstr("no segment"));
  EXPECT_EQ(ReadTickets(path), std::nullopt);
}

// Format 2 was HDF5 alone.
TEST(SegmentTest, AnEarlierFormatIsAnErrorThatSaysSo) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.h5";
  std::vector<std::uint8_t> bytes = EncodeSegment(RandomRecords(0, 1));
  bytes.resize(IndexAtEnd(bytes).value().hdf5_bytes);
  Write(path, bytes);
  EXPECT_THAT(MessageOf([&] { Read(path); }),
              AllOf(HasSubstr(path), HasSubstr("another format"), HasSubstr("reads format 3")));
}

TEST(SegmentTest, ASegmentCutShortIsDamaged) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.h5";
  const std::vector<std::uint8_t> whole = EncodeSegment(RandomRecords(0, 20));
  const std::size_t index = IndexBytes(whole).value();
  for (std::size_t size = 0; size < whole.size(); size += 1 + whole.size() / 50) {
    if (size == whole.size() - 2 * index) continue;
    Write(path, std::span(whole).first(size));
    const SegmentDamage damage = DamageOf(path);
    ASSERT_NE(damage.reason, "");
    const bool known = size >= whole.size() - index;
    ASSERT_EQ(LostText(damage), known ? "none" : "unknown") << size << " of " << whole.size();
  }
}

TEST(SegmentTest, DamageToWhatIsHdf5sLosesNothing) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.h5";
  std::vector<std::uint8_t> bytes = EncodeSegment(RandomRecords(7, 3));
  bytes[1] ^= 1;  // the signature
  Write(path, bytes);
  const SegmentDamage damage = DamageOf(path);
  EXPECT_EQ(damage.reason, "its checksum is wrong");
  EXPECT_EQ(LostText(damage), "none");
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
  EXPECT_EQ(ReadTickets(path).value().size(), games.size());
  close(file);
}

// Whatever byte is another: what is given is what was stored, and what is not is said to be lost.
TEST(SegmentTest, AFlippedByteIsNoticedAndLosesAtMostItsGame) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.h5";
  const std::vector<GameRecord> games = RandomRecords(0, 20);
  const std::vector<std::uint8_t> whole = EncodeSegment(games);
  Rng rng(5);
  std::size_t lost = 0;
  for (int i = 0; i < 500; ++i) {
    std::vector<std::uint8_t> bytes = whole;
    const std::uint32_t place = rng.Below(static_cast<std::uint32_t>(bytes.size()));
    bytes[place] ^= static_cast<std::uint8_t>(1 + rng.Below(255));
    Write(path, bytes);
    std::set<std::uint64_t> given;
    const SegmentDamage damage = ReadSegment(path, [&](GameRecord&& game) {
      ASSERT_EQ(game, games.at(game.ticket)) << place;
      given.insert(game.ticket);
    });
    ASSERT_NE(damage.reason, "") << place;
    for (const std::uint64_t ticket : damage.lost.value()) ASSERT_TRUE(given.insert(ticket).second);
    ASSERT_EQ(given.size(), games.size()) << place;
    ASSERT_LE(damage.lost->size(), 1u) << place;
    lost += damage.lost->size();
  }
  EXPECT_GT(lost, 0u);
}

TEST(SegmentTest, AnyBytesNeverCrash) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.h5";
  const std::vector<std::uint8_t> whole = EncodeSegment(RandomRecords(0, 3));
  Rng rng(6);
  for (int i = 0; i < 300; ++i) {
    std::vector<std::uint8_t> bytes = whole;
    const std::uint32_t start = rng.Below(static_cast<std::uint32_t>(bytes.size()));
    const std::size_t end = std::min<std::size_t>(bytes.size(), start + 1 + rng.Below(2000));
    for (std::size_t k = start; k < end; ++k) bytes[k] = static_cast<std::uint8_t>(rng.Below(256));
    Write(path, bytes);
    MessageOf([&] { (void)DamageOf(path); });
    (void)ReadTickets(path);
  }
}

TEST(SegmentTest, AGameWithAWrongValueIsLeftOut) {
  const SegmentColumns whole = ToColumns(RandomRecords(0, 8));
  std::vector<std::uint64_t> left_out;
  const auto reason = [&](auto&& damage) {
    SegmentColumns columns = whole;
    damage(columns);
    left_out = {0, 1, 2, 3, 4, 5, 6, 7};
    return ForEachWholeGame(columns, [&](GameRecord&& game) { std::erase(left_out, game.ticket); });
  };
  EXPECT_EQ(reason([](SegmentColumns&) {}), "");
  EXPECT_TRUE(left_out.empty());
  EXPECT_THAT(reason([](auto& c) { c.games.mode[0] = 0; }), HasSubstr("mode"));
  EXPECT_THAT(left_out, testing::ElementsAre(0));
  EXPECT_THAT(reason([](auto& c) { c.games.result[0] = 3; }), HasSubstr("result"));
  EXPECT_THAT(reason([](auto& c) { c.games.seat_policy[0][2] = 5; }), HasSubstr("seat_policy"));
  EXPECT_THAT(reason([](auto& c) { c.games.evaluator[0] = 2; }), HasSubstr("evaluator"));
  EXPECT_THAT(reason([](auto& c) { c.games.step_count[7] += 1; }), HasSubstr("ends within"));
  EXPECT_THAT(reason([](auto& c) { c.games.first_step[7] = ~std::uint64_t{}; }),
              HasSubstr("ends within"));
  EXPECT_THAT(reason([](auto& c) { c.games.step_count[3] -= 1; }), HasSubstr("checksum"));
  EXPECT_THAT(left_out, testing::ElementsAre(3));
  EXPECT_THAT(reason([](auto& c) { c.games.decision_count[1][0] += 1; }),
              HasSubstr("out of order"));
  EXPECT_THAT(left_out, testing::ElementsAre(1));
  EXPECT_THAT(reason([](auto& c) { c.steps.actions[0] = 6; }), HasSubstr("action above 5"));
  EXPECT_THAT(reason([](auto& c) { c.decisions.agent[0] = 4; }), HasSubstr("out of order"));
  EXPECT_THAT(reason([](auto& c) { c.decisions.value[0] = -c.decisions.value[0]; }),
              HasSubstr("checksum"));
  EXPECT_THAT(reason([](auto& c) { c.games.seat_teaches[0][1] = 3; }), HasSubstr("seat_teaches"));
  EXPECT_THAT(reason([](auto& c) { c.games.seed.pop_back(); }), HasSubstr("games/seed has 7 rows"));
  EXPECT_EQ(left_out.size(), 8u);
}

}  // namespace
}  // namespace powderkeg

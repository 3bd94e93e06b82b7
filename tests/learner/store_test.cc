#include "learner/replay/store.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <set>

#include "common/base/check.h"
#include "common/base/durable_file.h"
#include "tests/learner/record_support.h"

namespace powderkeg {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr auto kAll = [](std::uint64_t) { return true; };

std::vector<GameRecord> LoadAll(ReplayStore& store) {
  std::vector<GameRecord> games;
  store.Load(kAll, [&](GameRecord&& game) { games.push_back(std::move(game)); });
  return games;
}

std::vector<GameRecord> LoadAll(const fs::path& folder) {
  ReplayStore store(folder);
  return LoadAll(store);
}

std::string MessageOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(ReplayStore, GivesBackWhatWasAppended) {
  const TemporaryFolder folder;
  std::vector<GameRecord> games = RandomRecords(0, 100);
  games[7].actions.clear();
  games[7].tracks = {};
  {
    ReplayStore store(folder.path() / "replay");
    store.Append(std::span(games).first(40));
    store.Append(std::span(games).subspan(40));
    store.Append({});
    EXPECT_EQ(FilesIn(folder.path() / "replay").size(), 2u);
    EXPECT_EQ(LoadAll(store), games);
  }
  EXPECT_EQ(LoadAll(folder.path() / "replay"), games);
}

TEST(ReplayStore, MergesWhileAnotherProgramHoldsASegmentsLock) {
  const TemporaryFolder folder;
  const std::vector<GameRecord> games = RandomRecords(0, 2);
  ReplayStore store(folder.path());
  for (const GameRecord& game : games) store.Append(std::span(&game, 1));
  const int file = open(FilesIn(folder.path()).front().c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_EQ(flock(file, LOCK_EX | LOCK_NB), 0);
  store.Merge();
  close(file);
  EXPECT_EQ(FilesIn(folder.path()).size(), 1u);
  EXPECT_EQ(LoadAll(store), games);
}

TEST(ReplayStore, StaysWithinASizeAsFarAsGamesAreNotWanted) {
  const TemporaryFolder folder;
  const std::vector<GameRecord> games = RandomRecords(0, 5);
  ReplayStore store(folder.path());
  for (const GameRecord& game : games) store.Append(std::span(&game, 1));
  const auto wanted = [](std::uint64_t ticket) { return ticket == 1 || ticket >= 4; };
  EXPECT_EQ(store.Trim(std::uint64_t{1} << 30, wanted), 0u);
  EXPECT_EQ(LoadAll(store), games);
  const std::uint64_t all_but_one = 4 * fs::file_size(FilesIn(folder.path()).front()) + 10'000;
  EXPECT_EQ(store.Trim(all_but_one, wanted), 1u) << "the oldest goes";
  EXPECT_EQ(store.Trim(0, wanted), 2u);
  const std::vector<GameRecord> left = {games[1], games[4]};
  EXPECT_EQ(LoadAll(store), left);
  EXPECT_EQ(LoadAll(folder.path()), left);
}

TEST(ReplayStore, NumbersGoOnAfterARestart) {
  const TemporaryFolder folder;
  ReplayStore(folder.path()).Append(RandomRecords(0, 1));
  ReplayStore(folder.path()).Append(RandomRecords(1, 1));
  EXPECT_THAT(FilesIn(folder.path()), testing::ElementsAre(folder.path() / "segment-00000001.h5",
                                                           folder.path() / "segment-00000002.h5"));
}

TEST(ReplayStore, DropsDoublesByTicket) {
  const TemporaryFolder folder;
  ReplayStore store(folder.path());
  store.Append(RandomRecords(0, 5));
  store.Append(RandomRecords(3, 5));
  EXPECT_EQ(LoadAll(store).size(), 8u);
}

TEST(ReplayStore, MergeLeavesOneSegmentWithTheSameGames) {
  const TemporaryFolder folder;
  ReplayStore store(folder.path());
  for (std::uint64_t i = 0; i < 10; ++i) store.Append(RandomRecords(i * 5, 5));
  const std::vector<GameRecord> before = LoadAll(store);
  store.Merge();
  EXPECT_EQ(FilesIn(folder.path()).size(), 1u);
  EXPECT_EQ(LoadAll(store), before);
  store.Merge();
  store.Append(RandomRecords(50, 5));
  EXPECT_EQ(LoadAll(folder.path()).size(), 55u);
}

TEST(ReplayStore, LoadsOnlyWhatIsWantedAndKnowsEveryTicket) {
  const TemporaryFolder folder;
  ReplayStore store(folder.path());
  for (std::uint64_t i = 0; i < 4; ++i) store.Append(RandomRecords(i * 5, 5));
  store.Append(RandomRecords(0, 7));  // doubles
  std::vector<std::uint64_t> loaded;
  const std::vector<std::uint64_t> stored =
      store.Load([](std::uint64_t ticket) { return ticket >= 13; },
                 [&](GameRecord&& game) {
                   EXPECT_EQ(game, RandomRecords(game.ticket / 5 * 5, 5).at(game.ticket % 5));
                   loaded.push_back(game.ticket);
                 });
  EXPECT_EQ(stored.size(), 20u);
  EXPECT_EQ(loaded, (std::vector<std::uint64_t>{13, 14, 15, 16, 17, 18, 19}));
}

TEST(ReplayStore, SegmentsThatAreNotWantedAreNotReadWhole) {
  const TemporaryFolder folder;
  ReplayStore store(folder.path());
  std::vector<GameRecord> games = RandomRecords(0, 5);
  games[0].actions.resize(10'000);
  store.Append(games);
  ASSERT_EQ(store.small_segment_count(), 1u);
  EXPECT_EQ(
      store.Load([](std::uint64_t) { return false; }, [](GameRecord&&) { FAIL() << "it was read"; })
          .size(),
      5u);
}

TEST(ReplayStore, ACrashBetweenMergeAndRemovalLeavesNoDoubles) {
  const TemporaryFolder folder;
  const TemporaryFolder backup;
  ReplayStore store(folder.path());
  store.Append(RandomRecords(0, 5));
  store.Append(RandomRecords(5, 5));
  fs::copy(folder.path(), backup.path());
  store.Merge();
  fs::copy(backup.path(), folder.path());  // the originals are back
  ReplayStore restarted(folder.path());
  EXPECT_EQ(FilesIn(folder.path()).size(), 3u);
  EXPECT_EQ(LoadAll(restarted).size(), 10u);
  restarted.Merge();
  EXPECT_EQ(FilesIn(folder.path()).size(), 1u);
  EXPECT_EQ(LoadAll(restarted).size(), 10u);
}

TEST(ReplayStore, DeletesStaleTemporariesAndIgnoresOtherFiles) {
  const TemporaryFolder folder;
  const fs::path stale = folder.path() / "segment-00000001.h5.tmp";
  std::ofstream(stale) << "half a segment";
  std::ofstream(folder.path() / "notes.txt") << "mine";
  std::ofstream(folder.path() / "segment-old.h5") << "mine too";
  ReplayStore store(folder.path());
  EXPECT_FALSE(fs::exists(stale));
  EXPECT_TRUE(LoadAll(store).empty());
  EXPECT_EQ(FilesIn(folder.path()).size(), 2u);
}

// ---- Damage -------------------------------------------------------------------------------------

void FlipByte(const fs::path& path, std::size_t place, std::uint8_t bits) {
  std::vector<std::uint8_t> bytes = ReadFileBytes(path);
  bytes.at(place) ^= bits;
  WriteFileDurably(path, bytes);
}

std::set<std::uint64_t> TicketsOf(const std::vector<GameRecord>& games) {
  std::set<std::uint64_t> tickets;
  for (const GameRecord& game : games) tickets.insert(game.ticket);
  return tickets;
}

// Whatever byte is another: every game that is given is the one that was stored, every one that is
// not is said to be lost, what was given stays when loaded again, and the damaged file is kept.
TEST(ReplayStore, AFlippedByteAnywhereLosesOnlyWhatItHit) {
  Rng rng(12);
  const std::vector<GameRecord> games = RandomRecords(0, 40);
  constexpr std::size_t kTrials = 20;
  for (std::size_t trial = 0; trial < kTrials; ++trial) {
    const TemporaryFolder folder;
    const fs::path path = folder.path() / "segment-00000001.h5";
    { ReplayStore(folder.path()).Append(games); }
    const auto size = static_cast<std::uint32_t>(fs::file_size(path));
    FlipByte(path, rng.Below(size), static_cast<std::uint8_t>(1 + rng.Below(255)));
    ReplayStore store(folder.path());
    const std::vector<GameRecord> loaded = LoadAll(store);
    for (const GameRecord& game : loaded) ASSERT_EQ(game, games.at(game.ticket)) << trial;
    const std::set<std::uint64_t> tickets = TicketsOf(loaded);
    ASSERT_EQ(tickets.size(), loaded.size());
    ASSERT_EQ(loaded.size() + store.lost_tickets().size(), games.size()) << trial;
    for (const std::uint64_t ticket : store.lost_tickets()) ASSERT_FALSE(tickets.contains(ticket));
    ASSERT_LE(store.lost_tickets().size(), 1u) << trial;
    ASSERT_EQ(TicketsOf(LoadAll(folder.path())), tickets);
    ASSERT_TRUE(fs::exists(path.string() + ".damaged")) << trial;
  }
}

TEST(ReplayStore, AFlippedTicketIsNotBelieved) {
  const std::vector<std::uint8_t> whole = EncodeSegment(RandomRecords(0, 5));
  for (std::size_t back = 1; back < 900; back += 83) {
    const TemporaryFolder folder;
    const fs::path path = folder.path() / "segment-00000001.h5";
    WriteFileDurably(path, whole);
    FlipByte(path, whole.size() - back, 64);
    ReplayStore store(folder.path());
    const auto stored = store.Load([](std::uint64_t) { return false; }, [](GameRecord&&) {});
    ASSERT_THAT(stored, testing::UnorderedElementsAre(0, 1, 2, 3, 4)) << back;
  }
}

TEST(ReplayStore, ADamagedSegmentIsSetAsideAndTheOthersGoOn) {
  const TemporaryFolder folder;
  ReplayStore store(folder.path());
  store.Append(RandomRecords(0, 50));
  store.Append(RandomRecords(50, 50));
  store.Append(RandomRecords(100, 50));
  const fs::path damaged = folder.path() / "segment-00000002.h5";
  fs::resize_file(damaged, fs::file_size(damaged) / 2);
  const std::vector<std::uint8_t> bytes = ReadFileBytes(damaged);
  EXPECT_EQ(LoadAll(store).size(), 100u);
  EXPECT_FALSE(fs::exists(damaged));
  EXPECT_EQ(ReadFileBytes(damaged.string() + ".damaged"), bytes);
  fs::resize_file(folder.path() / "segment-00000001.h5", 0);
  EXPECT_EQ(LoadAll(store).size(), 50u);
}

TEST(ReplayStore, MergingDoesNotSpreadDamage) {
  const TemporaryFolder folder;
  ReplayStore store(folder.path());
  const std::vector<GameRecord> games = RandomRecords(0, 20);
  for (std::size_t i = 0; i < 4; ++i) store.Append(std::span(games).subspan(i * 5, 5));
  const fs::path damaged = folder.path() / "segment-00000003.h5";
  const std::uint64_t seed = games[12].setup.seed;
  const std::span seed_bytes(reinterpret_cast<const std::uint8_t*>(&seed), sizeof(seed));
  const std::vector<std::uint8_t> bytes = ReadFileBytes(damaged);
  const auto place = std::ranges::search(bytes, seed_bytes).begin() - bytes.begin();
  FlipByte(damaged, static_cast<std::size_t>(place), 4);
  store.Merge();
  EXPECT_THAT(store.lost_tickets(), testing::ElementsAre(12));
  EXPECT_TRUE(fs::exists(damaged.string() + ".damaged"));
  for (const GameRecord& game : LoadAll(store)) EXPECT_EQ(game, games.at(game.ticket));
  EXPECT_EQ(LoadAll(store).size(), 19u);
  EXPECT_EQ(FilesIn(folder.path()).size(), 2u);
}

// After a crash in the middle of a merge.
TEST(ReplayStore, ADoubleStandsInForADamagedGame) {
  const TemporaryFolder folder;
  ReplayStore store(folder.path());
  store.Append(RandomRecords(0, 5));
  store.Append(RandomRecords(0, 5));
  fs::resize_file(folder.path() / "segment-00000001.h5", 5000);
  EXPECT_EQ(LoadAll(store).size(), 5u);
}

TEST(ReplayStore, AFolderThatCannotBeMadeIsAnError) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "file") << "not a folder";
  EXPECT_THAT(MessageOf([&] { ReplayStore store(folder.path() / "file"); }), HasSubstr("file"));
}

// Runs `action` in a child process; its result is the child's exit status.
int InChild(const std::function<int()>& action) {
  const pid_t child = fork();
  if (child == 0) _exit(action());
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(ReplayStore, AFullDiskIsAnErrorAndLosesNothing) {
  const TemporaryFolder folder;
  ReplayStore(folder.path()).Append(RandomRecords(0, 5));
  const int status = InChild([&] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{4096, 4096};  // as if the disk had room for one page
    setrlimit(RLIMIT_FSIZE, &limit);
    ReplayStore store(folder.path());
    const std::string message = MessageOf([&] { store.Append(RandomRecords(5, 500)); });
    return message.find("cannot write") != std::string::npos ? 0 : 1;
  });
  EXPECT_EQ(status, 0);
  EXPECT_EQ(LoadAll(folder.path()).size(), 5u);
}

// ---- kill -9 ------------------------------------------------------------------------------------

constexpr std::uint64_t kGamesPerSegment = 4;

// Appends and merges until killed; a byte into `pipe` acknowledges each append.
[[noreturn]] void AppendForever(const fs::path& folder, int pipe) {
  ReplayStore store(folder);
  std::uint64_t ticket = LoadAll(store).size();
  for (int i = 1;; ++i) {
    store.Append(RandomRecords(ticket, kGamesPerSegment));
    ticket += kGamesPerSegment;
    if (write(pipe, "a", 1) != 1) _exit(1);
    if (i % 3 == 0) store.Merge();
  }
}

// Starts a child, kills it soon after a random number of appends; how many it acknowledged.
std::uint64_t AppendsBeforeKill(const fs::path& folder, Rng& rng) {
  int ends[2];
  CHECK(pipe(ends) == 0);
  const pid_t child = fork();
  if (child == 0) AppendForever(folder, ends[1]);
  close(ends[1]);
  std::uint64_t acknowledged = 0;
  char byte;
  for (std::uint32_t i = 0, count = 1 + rng.Below(8); i < count; ++i) {
    acknowledged += static_cast<std::uint64_t>(read(ends[0], &byte, 1));
  }
  usleep(rng.Below(3000));  // into the middle of something
  kill(child, SIGKILL);
  while (read(ends[0], &byte, 1) == 1) ++acknowledged;
  close(ends[0]);
  waitpid(child, nullptr, 0);
  return acknowledged;
}

TEST(ReplayStore, AKillAtAnyMomentLosesNothingAcknowledged) {
  Rng rng(11);
  const TemporaryFolder folder;
  std::uint64_t games = 0;
  for (int trial = 0; trial < 30; ++trial) {
    const std::uint64_t appends = AppendsBeforeKill(folder.path(), rng);
    std::set<std::uint64_t> tickets;
    for (const GameRecord& game : LoadAll(folder.path())) {
      ASSERT_TRUE(tickets.insert(game.ticket).second);
      ASSERT_EQ(game, RandomRecord(game.ticket, static_cast<int>(game.actions.size()),
                                   static_cast<int>(DecisionCount(game))));
    }
    ASSERT_GE(tickets.size(), games + appends * kGamesPerSegment);
    // One append may have become durable without being acknowledged.
    ASSERT_LE(tickets.size(), games + (appends + 1) * kGamesPerSegment);
    ASSERT_EQ(*tickets.rbegin(), tickets.size() - 1);
    games = tickets.size();
  }
}

}  // namespace
}  // namespace powderkeg

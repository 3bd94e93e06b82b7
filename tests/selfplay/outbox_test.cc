#include "actors/selfplay/outbox.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <fstream>
#include <iterator>
#include <thread>

#include "actors/selfplay/ticket_book.h"
#include "common/base/check.h"
#include "tests/selfplay/session_support.h"

namespace {

std::atomic<int> syncs = 0;
thread_local int syncs_here = 0;
std::atomic<bool> sync_fails = false;

}  // namespace

// Stands for the system's in this program.
extern "C" int fdatasync(int file) {
  ++syncs;
  ++syncs_here;
  return sync_fails ? -1 : fsync(file);
}

namespace powderkeg {
namespace {

constexpr std::size_t kLimit = 10'000;

SealedGame FakeGame(std::uint64_t ticket, std::size_t size = 100) {
  SealedGame game;
  game.ticket = ticket;
  game.record = std::string(size, static_cast<char>('a' + ticket % 26));
  game.checksum = static_cast<std::uint32_t>(ticket * 77);
  game.settings_digest[31] = static_cast<std::uint8_t>(ticket);
  return game;
}

class OutboxTest : public testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path File() const { return spool_.path() / "outbox.spool"; }
  [[nodiscard]] std::string Bytes() const {
    std::ifstream input(File(), std::ios::binary);
    return {std::istreambuf_iterator<char>(input), {}};
  }
  void SetBytes(const std::string& bytes) const {
    std::ofstream(File(), std::ios::binary | std::ios::trunc) << bytes;
  }
  TemporarySpool spool_;
};

TEST_F(OutboxTest, KeepsGamesOverARestart) {
  {
    Outbox outbox(spool_.path(), kLimit);
    for (const std::uint64_t ticket : {5, 3, 9}) outbox.Add(FakeGame(ticket));
    outbox.Remove(3);
  }
  Outbox outbox(spool_.path(), kLimit);
  // Removals are not written: game 3 is back, and would be acknowledged again.
  EXPECT_EQ(outbox.Tickets(), (std::vector<std::uint64_t>{3, 5, 9}));
  std::uint64_t cursor = 0;
  EXPECT_EQ(outbox.Batch(cursor, kLimit),
            (std::vector<SealedGame>{FakeGame(5), FakeGame(3), FakeGame(9)}));
}

TEST_F(OutboxTest, BatchesGoOnWhereTheyWere) {
  Outbox outbox(spool_.path(), kLimit);
  for (std::uint64_t ticket = 0; ticket < 5; ++ticket) outbox.Add(FakeGame(ticket));
  std::uint64_t cursor = 0;
  EXPECT_EQ(outbox.Batch(cursor, 250).size(), 2u);
  outbox.Remove(2);
  EXPECT_EQ(outbox.Batch(cursor, 1), (std::vector<SealedGame>{FakeGame(3)}));
  EXPECT_EQ(outbox.Batch(cursor, 1), (std::vector<SealedGame>{FakeGame(4)}));
  EXPECT_TRUE(outbox.Batch(cursor, 1).empty());
}

TEST_F(OutboxTest, IsEmptiedWhenEverythingIsAcknowledged) {
  Outbox outbox(spool_.path(), kLimit);
  for (std::uint64_t ticket = 0; ticket < 5; ++ticket) outbox.Add(FakeGame(ticket));
  for (std::uint64_t ticket = 0; ticket < 5; ++ticket) outbox.Remove(ticket);
  EXPECT_EQ(Bytes(), "PKSPOOL1");
  EXPECT_EQ(outbox.bytes(), 0u);
}

TEST_F(OutboxTest, IsRewrittenWhenMostIsAcknowledged) {
  constexpr std::size_t kLarge = 300'000;
  {
    Outbox outbox(spool_.path(), kLimit);
    for (std::uint64_t ticket = 0; ticket < 6; ++ticket) outbox.Add(FakeGame(ticket, kLarge));
    for (std::uint64_t ticket = 0; ticket < 5; ++ticket) outbox.Remove(ticket);
    EXPECT_LT(std::filesystem::file_size(File()), 2 * kLarge);
    outbox.Add(FakeGame(7));
  }
  EXPECT_EQ(Outbox(spool_.path(), kLimit).Tickets(), (std::vector<std::uint64_t>{5, 7}));
}

TEST_F(OutboxTest, IsFullByBytes) {
  Outbox outbox(spool_.path(), 150);
  outbox.Add(FakeGame(1));
  EXPECT_FALSE(outbox.full());
  outbox.Add(FakeGame(2));
  EXPECT_TRUE(outbox.full());
  outbox.Remove(1);
  EXPECT_FALSE(outbox.full());
}

TEST_F(OutboxTest, TheSameTicketIsKeptOnce) {
  Outbox outbox(spool_.path(), kLimit);
  outbox.Add(FakeGame(1));
  outbox.Add(FakeGame(1));
  EXPECT_EQ(outbox.size(), 1u);
}

TEST_F(OutboxTest, DropsACutOffEndAtEveryLength) {
  {
    Outbox outbox(spool_.path(), kLimit);
    outbox.Add(FakeGame(1, 20));
    outbox.Add(FakeGame(2, 20));
  }
  const std::string whole = Bytes();
  const std::size_t entry = (whole.size() - 8) / 2;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    SetBytes(whole.substr(0, size));
    Outbox outbox(spool_.path(), kLimit);
    EXPECT_EQ(outbox.size(), size < 8 + entry ? 0u : 1u) << size;
    outbox.Add(FakeGame(3, 20));  // goes on behind what is whole
    EXPECT_EQ(std::filesystem::file_size(File()), 8 + (outbox.size()) * entry);
  }
}

TEST_F(OutboxTest, DropsADamagedEnd) {
  {
    Outbox outbox(spool_.path(), kLimit);
    outbox.Add(FakeGame(1));
    outbox.Add(FakeGame(2));
  }
  std::string bytes = Bytes();
  bytes[bytes.size() - 5] ^= 1;
  SetBytes(bytes);
  EXPECT_EQ(Outbox(spool_.path(), kLimit).Tickets(), (std::vector<std::uint64_t>{1}));
}

// Wherever it is: in a length, a checksum, a ticket or a record.
TEST_F(OutboxTest, AFlippedBitDropsItsGameAlone) {
  {
    Outbox outbox(spool_.path(), kLimit);
    for (std::uint64_t ticket = 1; ticket <= 3; ++ticket) outbox.Add(FakeGame(ticket, 20));
  }
  const std::string whole = Bytes();
  const std::size_t entry = (whole.size() - 8) / 3;
  for (std::size_t at = 8 + entry; at < 8 + 2 * entry; ++at) {
    std::string bytes = whole;
    bytes[at] ^= static_cast<char>(1 << at % 8);
    SetBytes(bytes);
    Outbox outbox(spool_.path(), kLimit);
    ASSERT_EQ(outbox.Tickets(), (std::vector<std::uint64_t>{1, 3})) << at;
    outbox.Add(FakeGame(4, 20));
    ASSERT_EQ(Bytes().size(), whole.size()) << "the damage is still there";
  }
}

// No game loop waits for a disk.
TEST_F(OutboxTest, AnotherThreadSyncsWhatIsAdded) {
  Outbox outbox(spool_.path(), kLimit);
  const int before = syncs;
  const int here_before = syncs_here;
  for (std::uint64_t ticket = 0; ticket < 5; ++ticket) outbox.Add(FakeGame(ticket));
  EXPECT_EQ(syncs_here, here_before);
  EXPECT_TRUE(Eventually([&] { return syncs > before; }));
}

TEST_F(OutboxTest, ADiskThatFailsIsAnError) {
  Outbox outbox(spool_.path(), kLimit);
  outbox.Add(FakeGame(0));
  sync_fails = true;
  EXPECT_TRUE(Eventually([&] {
    try {
      outbox.Add(FakeGame(outbox.size()));
      return false;
    } catch (const Error&) {
      return true;
    }
  }));
  sync_fails = false;
}

// Half of the games come while the file is rewritten.
TEST_F(OutboxTest, WhatIsAddedDuringARewriteIsKept) {
  constexpr std::uint64_t kGames = 400;
  {
    Outbox outbox(spool_.path(), kLimit);
    std::atomic<std::uint64_t> added = 0;
    const std::jthread adder([&] {
      for (; added < kGames; ++added) outbox.Add(FakeGame(added, 20'000));
    });
    for (std::uint64_t ticket = 0; ticket < kGames; ticket += 2) {
      ASSERT_TRUE(Eventually([&] { return added > ticket; }));
      outbox.Remove(ticket);
    }
  }
  const std::vector<std::uint64_t> kept = Outbox(spool_.path(), kLimit).Tickets();
  for (std::uint64_t ticket = 1; ticket < kGames; ticket += 2) {
    EXPECT_TRUE(std::ranges::binary_search(kept, ticket)) << ticket;
  }
}

TEST_F(OutboxTest, RefusesAnotherFileAndASecondOwner) {
  {
    const Outbox outbox(spool_.path(), kLimit);
    EXPECT_THROW(Outbox(spool_.path(), kLimit), Error);
  }
  SetBytes("something else that is long enough");
  EXPECT_THROW(Outbox(spool_.path(), kLimit), Error);
}

TEST_F(OutboxTest, SurvivesAKill) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    Outbox outbox(spool_.path(), kLimit);
    for (std::uint64_t ticket = 0; ticket < 3; ++ticket) outbox.Add(FakeGame(ticket));
    kill(getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(Outbox(spool_.path(), kLimit).size(), 3u);
}

// What a full disk leaves: the games before it, and room for those after it.
TEST_F(OutboxTest, AFullDiskIsAnErrorAndHidesNoGame) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    Outbox outbox(spool_.path(), kLimit);
    outbox.Add(FakeGame(0));
    rlimit limit{Bytes().size() + 60, RLIM_INFINITY};  // half a game
    setrlimit(RLIMIT_FSIZE, &limit);
    bool refused = false;
    try {
      outbox.Add(FakeGame(1));
    } catch (const Error&) {
      refused = outbox.size() == 1;
    }
    limit.rlim_cur = RLIM_INFINITY;
    setrlimit(RLIMIT_FSIZE, &limit);
    outbox.Add(FakeGame(2));
    _exit(refused ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_EQ(Outbox(spool_.path(), kLimit).Tickets(), (std::vector<std::uint64_t>{0, 2}));
}

// Too many open files is no reason to take the spool for empty.
TEST_F(OutboxTest, AFileThatCannotBeReadIsNotEmptied) {
  { Outbox(spool_.path(), kLimit).Add(FakeGame(1)); }
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const int next = dup(0);  // the number that the spool's file will have
    close(next);
    const rlimit limit{static_cast<rlim_t>(next) + 1, static_cast<rlim_t>(next) + 1};
    if (setrlimit(RLIMIT_NOFILE, &limit) != 0) _exit(1);
    try {
      const Outbox outbox(spool_.path(), kLimit);
    } catch (const Error&) {
    }
    _exit(0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_EQ(Outbox(spool_.path(), kLimit).size(), 1u);
}

TEST_F(OutboxTest, GamesOfAnotherRunAreSetAside) {
  using Tickets = std::vector<std::uint64_t>;
  {
    Outbox outbox(spool_.path(), kLimit);
    outbox.Add(FakeGame(1));
    EXPECT_EQ(outbox.ServeRun("first"), Tickets{}) << "nobody has said of which run it is";
    outbox.Add(FakeGame(2));
    EXPECT_EQ(outbox.ServeRun("first"), Tickets{});
  }
  Outbox outbox(spool_.path(), kLimit);
  EXPECT_EQ(outbox.ServeRun("../second"), (Tickets{1, 2}));
  EXPECT_EQ(outbox.size(), 0u);
  EXPECT_EQ(outbox.bytes(), 0u);
  outbox.Add(FakeGame(1));
  EXPECT_EQ(outbox.ServeRun("first"), Tickets{1});
  EXPECT_EQ(Bytes(), "PKSPOOL1");
  const TemporarySpool other;
  std::filesystem::copy(spool_.path() / "outbox-first.spool", other.path() / "outbox.spool");
  EXPECT_EQ(Outbox(other.path(), kLimit).Tickets(), (Tickets{1, 2})) << "kept whole";
  EXPECT_TRUE(std::filesystem::exists(spool_.path() / "outbox-.._second.spool"));
}

TEST(TicketBookTest, GivesTheLowestAndForgetsTheSettled) {
  TicketBook book;
  book.Grant(std::vector<std::uint64_t>{7, 2, 5});
  book.GrantPlayed(std::vector<std::uint64_t>{1});
  EXPECT_EQ(book.Take(), (Grant{.ticket = 2}));
  book.Settle(5);
  EXPECT_EQ(book.Take(), (Grant{.ticket = 7}));
  EXPECT_FALSE(book.Take());
  book.PutBack(2);
  book.PutBack(5);  // settled: stays away
  EXPECT_EQ(book.waiting(), 1u);
  EXPECT_EQ(book.Take(), (Grant{.ticket = 2}));
  EXPECT_EQ(book.Held(), (std::vector<std::uint64_t>{1, 2, 7}));
}

TEST(TicketBookTest, WhatWaitsCanBeDropped) {
  TicketBook book;
  book.Grant(std::vector<std::uint64_t>{1, 2, 3});
  book.GrantPlayed(std::vector<std::uint64_t>{0});
  EXPECT_EQ(book.Take(), (Grant{.ticket = 1}));
  EXPECT_EQ(book.Started(), (std::vector<std::uint64_t>{0, 1}));
  book.DropWaiting();
  EXPECT_EQ(book.waiting(), 0u);
  EXPECT_EQ(book.Held(), (std::vector<std::uint64_t>{0, 1}));
}

TEST(TicketBookTest, GrantingAgainChangesNothing) {
  TicketBook book;
  book.Grant(std::vector<std::uint64_t>{1});
  EXPECT_EQ(book.Take(), (Grant{.ticket = 1}));
  book.Grant(std::vector<std::uint64_t>{1});
  EXPECT_EQ(book.waiting(), 0u);
}

}  // namespace
}  // namespace powderkeg

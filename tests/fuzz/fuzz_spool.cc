// Spools as a disk may give them back: any bytes, or a whole spool with other values here and
// there. What is read from the latter is what was added, and what is added then survives.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "actors/selfplay/outbox.h"
#include "common/base/check.h"
#include "common/base/log.h"
#include "tests/fuzz/byte_source.h"
#include "tests/learner/record_support.h"

namespace powderkeg {
namespace {

constexpr std::size_t kLimit = std::size_t{1} << 20;
constexpr std::uint64_t kNewTicket = 1'000'000;

SealedGame SomeGame(std::uint64_t ticket) {
  SealedGame game{.ticket = ticket, .record = std::string(40 + ticket, 'r')};
  game.settings_digest.fill(static_cast<std::uint8_t>(ticket));
  return game;
}

std::string Contents(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<SealedGame> GamesIn(const Outbox& outbox) {
  std::uint64_t cursor = 0;
  return outbox.Batch(cursor, kLimit);
}

// Opens a spool of these bytes twice, with a game added between.
void Reopen(const std::filesystem::path& folder, std::string_view spool, bool known) {
  std::ofstream(folder / "outbox.spool", std::ios::binary) << spool;
  std::vector<SealedGame> games;
  try {
    Outbox outbox(folder, kLimit);
    for (const SealedGame& game : GamesIn(outbox)) CHECK(!known || game == SomeGame(game.ticket));
    outbox.Add(SomeGame(kNewTicket % 1000));
    games = GamesIn(outbox);
  } catch (const Error&) {
    return;  // it says that it is no spool
  }
  CHECK(GamesIn(Outbox(folder, kLimit)) == games);
}

}  // namespace
}  // namespace powderkeg

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace powderkeg;
  static const TemporaryFolder folder("/dev/shm");
  static const std::string whole = [] {
    log::Init("", log::Level::kError);
    Outbox outbox(folder.path(), kLimit);
    for (std::uint64_t ticket = 1; ticket <= 4; ++ticket) outbox.Add(SomeGame(ticket));
    return Contents(folder.path() / "outbox.spool");
  }();
  ByteSource source(data, size);
  if (source.Next() % 4 == 0) {
    Reopen(folder.path(), source.Rest(), /*known=*/false);
    return 0;
  }
  std::string bytes = whole;
  Damage(source, bytes);
  Reopen(folder.path(), bytes, /*known=*/true);
  return 0;
}

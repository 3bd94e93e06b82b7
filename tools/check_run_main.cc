// check_run: reads a run's folder, changes nothing, and says what is lost, doubled or out of order.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/byte_stream.h"
#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/durable_file.h"
#include "common/base/run_main.h"
#include "common/record/ticket_set.h"
#include "common/segment/segment_file.h"

namespace powderkeg {
namespace {

namespace fs = std::filesystem;

using Tickets = std::vector<std::uint64_t>;

int faults = 0;

void Say(std::string_view text) { std::cout << text << "\n"; }
void Fault(std::string_view text) {
  ++faults;
  Say(StrCat("FAULT: ", text));
}

std::vector<fs::path> FilesWith(const fs::path& folder, std::string_view ending) {
  if (!fs::exists(folder)) return {};
  std::vector<fs::path> files = FilesIn(folder);
  std::erase_if(files, [&](const fs::path& file) { return !file.string().ends_with(ending); });
  return files;
}

// How often each ticket is stored.
std::map<std::uint64_t, int> CheckSegments(const fs::path& folder) {
  std::map<std::uint64_t, int> stored;
  const std::vector<fs::path> files = FilesWith(folder, ".h5");
  for (const fs::path& file : files) {
    const SegmentDamage damage =
        ReadSegment(file, [&](const GameRecord& game) { ++stored[game.ticket]; });
    if (damage.reason.empty()) continue;
    Fault(StrCat(file.string(), ": ", damage.reason, "; tickets lost: ", LostText(damage)));
  }
  for (const fs::path& file : FilesWith(folder, ".damaged")) {
    Tickets whole;
    const SegmentDamage damage =
        ReadSegment(file, [&](const GameRecord& game) { whole.push_back(game.ticket); });
    Say(StrCat(file.string(), ": set aside: ", damage.reason,
               "; tickets lost: ", LostText(damage)));
    std::erase_if(whole, [&](std::uint64_t ticket) { return stored.contains(ticket); });
    if (!whole.empty())
      Fault(StrCat(file.string(), ": in it alone are whole: ", TicketsText(whole)));
  }
  Tickets doubled;
  for (const auto& [ticket, times] : stored) {
    if (times > 1) doubled.push_back(ticket);
  }
  if (!doubled.empty()) {
    Fault(StrCat("stored twice (as while segments are merged): ", TicketsText(doubled)));
  }
  Say(StrCat("games: ", stored.size(), " in ", files.size(), " segments"));
  return stored;
}

struct DataSets {
  std::uint64_t count = 0;
  std::uint64_t end = 0;  // one more than the last ticket
};

// Of a checkpoint (learner/train/checkpoint.cc). Throws Error that says what is wrong.
DataSets ReadCheckpoint(const fs::path& file) {
  constexpr std::size_t kMark = 8;
  const std::vector<std::uint8_t> bytes = ReadFileBytes(file);
  ByteReader in(file.string(), bytes);
  if (in.ReadString(kMark) != "PKCHECK2") throw Error("it is of another format");
  const auto checksum = in.Read<std::uint32_t>();
  if (checksum != Crc32c(std::span(bytes).subspan(kMark + sizeof checksum))) {
    throw Error("its checksum is wrong");
  }
  DataSets sets{.count = in.ReadCount<std::uint64_t>(2 * sizeof(std::uint64_t)), .end = 0};
  for (std::uint64_t i = 0; i < sets.count; ++i) {
    const auto first = in.Read<std::uint64_t>();
    const auto last = in.Read<std::uint64_t>();
    if (first != sets.end || last < first) throw Error("its data sets do not follow each other");
    sets.end = last + 1;
  }
  return sets;
}

// The newest that is whole.
DataSets CheckCheckpoints(const fs::path& folder) {
  DataSets newest;
  const std::vector<fs::path> files = FilesWith(folder, ".checkpoint");
  for (const fs::path& file : files) {
    try {
      newest = ReadCheckpoint(file);
    } catch (const Error& error) {
      Fault(StrCat(file.string(), ": ", error.what()));
    }
  }
  Say(StrCat("checkpoints: ", files.size(), ", iterations done: ", newest.count,
             ", tickets used: ", newest.end));
  return newest;
}

// Rows 1 to `iterations` in order, each once; one more may stand there before its checkpoint does.
void CheckTable(const fs::path& file, std::uint64_t iterations) {
  std::ifstream table(file);
  std::string line;
  std::getline(table, line);
  const auto columns = std::ranges::count(line, ',');
  std::uint64_t expected = 1;
  while (std::getline(table, line)) {
    if (table.eof() || std::ranges::count(line, ',') != columns ||
        line.substr(0, line.find(',')) != std::to_string(expected)) {
      Fault(StrCat(file.string(), ": expected the whole row of iteration ", expected, ", found '",
                   line, "'"));
      return;
    }
    ++expected;
  }
  if (expected - 1 < iterations || expected - 1 > iterations + 1) {
    Fault(StrCat(file.string(), ": ", expected - 1, " rows, but ", iterations, " iterations done"));
  }
}

// Of what an actor has not seen acknowledged (actors/selfplay/outbox.h).
void CheckSpool(const fs::path& file, const std::map<std::uint64_t, int>& stored) {
  constexpr std::size_t kHeader = 8;
  const std::vector<std::uint8_t> bytes = ReadFileBytes(file);
  Tickets waiting;
  std::size_t at = kHeader;
  while (at + kHeader + sizeof(std::uint64_t) <= bytes.size()) {
    ByteReader in(file.string(), std::span(bytes).subspan(at));
    const auto size = in.Read<std::uint32_t>();
    const auto checksum = in.Read<std::uint32_t>();
    if (size < sizeof(std::uint64_t) || size > bytes.size() - at - kHeader ||
        checksum != Crc32c(std::span(bytes).subspan(at + kHeader, size))) {
      break;
    }
    waiting.push_back(in.Read<std::uint64_t>());
    at += kHeader + size;
  }
  if (at < bytes.size()) {
    Fault(StrCat(file.string(), ": damaged or cut off after ", waiting.size(), " games"));
  }
  const std::size_t all = waiting.size();
  std::erase_if(waiting, [&](std::uint64_t ticket) { return stored.contains(ticket); });
  Say(StrCat(file.string(), ": ", all, " games, of these not stored: ", TicketsText(waiting)));
}

int CheckRunFolder(const fs::path& run, bool list) {
  if (!fs::is_directory(run)) throw Error(StrCat(run.string(), " is no folder of a run"));
  const std::map<std::uint64_t, int> stored = CheckSegments(run / "replay");
  if (list) {
    for (const auto& [ticket, times] : stored) Say(StrCat("ticket ", ticket));
  }
  const DataSets done = CheckCheckpoints(run / "checkpoints");
  CheckTable(run / "iterations.csv", done.count);
  for (const auto& spool : fs::recursive_directory_iterator(run)) {
    if (spool.path().extension() == ".spool") CheckSpool(spool.path(), stored);
  }
  Tickets used;
  for (std::uint64_t ticket = 0; ticket < done.end; ++ticket) {
    if (!stored.contains(ticket)) used.push_back(ticket);
  }
  Say(StrCat("used and not stored (lost, or removed by training.replay_mb): ", TicketsText(used)));
  if (faults == 0) Say("no faults");
  return faults == 0 ? kDone : kFailed;
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  std::string run;
  bool list = false;
  CLI::App app(
      "Reads a run's folder, best while no learner works in it, and says what is lost, doubled or\n"
      "out of order in games, checkpoints, table and spools. Changes nothing; 1 if there is a "
      "fault.",
      "check_run");
  app.add_option("run", run, "runs/NAME")->required();
  app.add_flag("--tickets", list, "name every stored game by its ticket, one a line");
  return powderkeg::RunMain(app, argc, argv, [&] { return powderkeg::CheckRunFolder(run, list); });
}

#include "tools/board/game_library.h"

#include <algorithm>
#include <functional>
#include <system_error>
#include <tuple>

#include "common/base/check.h"
#include "common/config/config.h"
#include "common/record/game_setup.h"

namespace powderkeg {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostGames = 20'000;

bool IsRun(const std::string& source) {
  if (!fs::is_directory(source)) return false;
  if (fs::is_directory(fs::path(source) / "replay")) return true;
  throw Error(StrCat(source,
                     ": a folder without replay/, expected a run's (runs/NAME), a segment "
                     "(segment-*.h5) or recorded games (.jsonl, .jsonl.gz)"));
}

std::string NameAt(const std::vector<std::string>& names, std::size_t index) {
  return index < names.size() ? names[index] : "";
}

// The newest first: their names count upwards.
std::vector<fs::path> SegmentsOf(const fs::path& run) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(run / "replay")) {
    if (entry.path().extension() == ".h5") files.push_back(entry.path());
  }
  std::ranges::sort(files, std::greater<>());
  return files;
}

auto StampOf(const fs::path& file) {
  std::error_code unknown;
  return std::pair(fs::file_size(file, unknown), fs::last_write_time(file, unknown));
}

std::vector<ListedGame> RecordedGames(const fs::path& file) {
  std::vector<ListedGame> games;
  RecordedGameReader reader(file);
  for (RecordedGame game; reader.Next(game);) {
    ListedGame listed;
    listed.number = games.size();
    listed.lineup = game.mode;
    listed.steps = static_cast<int>(game.steps.size());
    listed.result = game.result;
    listed.winners = game.winners;
    listed.file = file;
    games.push_back(std::move(listed));
  }
  return games;
}

std::optional<StoredGame> ReadStored(const ListedGame& entry) {
  std::optional<StoredGame> stored;
  std::ignore = ReadSegment(entry.file, [&](const GameRecord& record) {
    if (record.ticket == entry.number) stored = StoredGameFrom(record);
  });
  if (stored) stored->players = entry.players;
  return stored;
}

}  // namespace

GameLibrary::GameLibrary(const std::string& source) : source_(source), run_(IsRun(source)) {
  if (run_) ReadNames();
  const GameList list = List();
  if (list.games.empty() && !list.notes.empty()) throw Error(list.notes.back());
}

// A run of other settings than today's has games without names.
void GameLibrary::ReadNames() {
  try {
    const RunGames games(LoadConfig(fs::path(source_) / "config.textproto", {}).self_play);
    for (const Player& player : games.players()) player_names_.push_back(player.name);
    for (const Lineup& lineup : games.lineups()) {
      lineup_names_.push_back(lineup.name + (lineup.exam ? ", exam" : ""));
    }
  } catch (const Error& error) {
    names_note_ = error.what();
  }
}

void GameLibrary::Look() {
  std::map<fs::path, Shelf> shelves;
  std::size_t games = 0;
  unread_ = 0;
  for (const fs::path& file : run_ ? SegmentsOf(source_) : std::vector<fs::path>{source_}) {
    if (games >= kMostGames) {
      ++unread_;
      continue;
    }
    const auto known = shelves_.find(file);
    const bool same = known != shelves_.end() && known->second.stamp == StampOf(file);
    const Shelf& shelf =
        shelves.emplace(file, same ? std::move(known->second) : ReadShelf(file)).first->second;
    games += shelf.games.size();
  }
  shelves_ = std::move(shelves);
}

GameLibrary::Shelf GameLibrary::ReadShelf(const fs::path& file) const {
  Shelf shelf{.stamp = StampOf(file), .games = {}, .note = {}};
  try {
    if (IsSegment(file)) {
      shelf.note = ListSegment(file, shelf.games);
    } else {
      shelf.games = RecordedGames(file);
    }
  } catch (const Error& error) {
    shelf.note = error.what();
  }
  return shelf;
}

std::string GameLibrary::ListSegment(const fs::path& file, std::vector<ListedGame>& games) const {
  const SegmentDamage damage = ReadSegment(file, [&](const GameRecord& record) {
    games.push_back(Listed(record));
    games.back().file = file;
  });
  return damage.reason.empty() ? "" : LeftOutText(file.string(), damage);
}

ListedGame GameLibrary::Listed(const GameRecord& record) const {
  ListedGame game;
  game.number = record.ticket;
  game.lineup = NameAt(lineup_names_, record.setup.lineup);
  game.steps = static_cast<int>(record.actions.size());
  game.result = record.outcome.result;
  game.winners = record.outcome.winners;
  for (AgentId id = 0; id < SeatCount(record.setup.settings.mode); ++id) {
    const Seat& seat = record.setup.seats[id];
    game.players[id] = NameAt(player_names_, seat.player);
    if (game.players[id].empty()) game.players[id] = seat.searches ? "search" : NameOf(seat.policy);
    const std::uint32_t version = record.tracks[id].weights_version;
    if (version < kFirstFileVersion) game.version = std::max(game.version, version);
  }
  return game;
}

GameList GameLibrary::List() {
  const std::lock_guard lock(mutex_);
  if (run_ || shelves_.empty()) Look();
  GameList list{.source = source_, .games = {}, .notes = {}};
  if (!names_note_.empty()) list.notes.push_back(names_note_);
  if (unread_ > 0) list.notes.push_back(StrCat(unread_, " older segments are not listed"));
  for (const auto& [file, shelf] : shelves_) {
    list.games.insert(list.games.end(), shelf.games.begin(), shelf.games.end());
    if (!shelf.note.empty()) list.notes.push_back(shelf.note);
  }
  std::ranges::sort(list.games, {}, &ListedGame::number);
  if (run_) std::ranges::reverse(list.games);
  return list;
}

std::optional<StoredGame> GameLibrary::Find(std::uint64_t number) {
  const std::lock_guard lock(mutex_);
  const ListedGame* entry = Entry(number);
  // Small segments are merged while a run goes on.
  if (run_ && (entry == nullptr || !fs::exists(entry->file))) {
    Look();
    entry = Entry(number);
  }
  if (entry == nullptr) return std::nullopt;
  if (!IsSegment(entry->file)) return ReadRecorded(*entry);
  return ReadStored(*entry);
}

const ListedGame* GameLibrary::Entry(std::uint64_t number) const {
  for (const auto& [file, shelf] : shelves_) {
    const auto found = std::ranges::find(shelf.games, number, &ListedGame::number);
    if (found != shelf.games.end()) return &*found;
  }
  return nullptr;
}

StoredGame GameLibrary::ReadRecorded(const ListedGame& entry) {
  if (!reader_ || next_ > entry.number) {
    reader_ = OpenGames(entry.file);
    next_ = 0;
  }
  StoredGame stored;
  while (next_ <= entry.number) {
    if (!reader_(stored)) throw Error(StrCat(source_, ": has changed, expected game ", next_));
    ++next_;
  }
  if (!stored.game.Known()) {
    throw Error(StrCat(stored.game.id, ": games of mode \"", stored.game.mode, "\" are not shown"));
  }
  return stored;
}

}  // namespace powderkeg

#pragma once

// The stored games that there are to look at.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/viewer/game_source.h"

namespace powderkeg {

// What a list says of a game.
struct ListedGame {
  std::uint64_t number =
      0;               // in a segment the ticket, in a file of recorded games the place, from 0
  std::string lineup;  // who plays, in a run's words; empty where it is not known
  std::array<std::string, kAgentCount> players;
  std::uint32_t version = 0;  // of the newest weights in it; 0: none
  int steps = 0;
  Result result = Result::kIncomplete;
  std::uint8_t winners = 0;
  std::filesystem::path file;
};

struct GameList {
  std::string source;              // what was asked for
  std::vector<ListedGame> games;   // ascending; of a run the newest first
  std::vector<std::string> notes;  // what could not be read, or is left out
};

// The games of a run's folder, of a segment or of a file of recorded games; of a run at most the
// newest 20,000 or somewhat more. Files may come and go meanwhile: of a run as it stands, they are
// looked at again. Thread-safe.
class GameLibrary {
 public:
  // Throws Error if there is nothing of the kind, or of another format.
  explicit GameLibrary(const std::string& source);

  [[nodiscard]] GameList List();
  [[nodiscard]] const std::string& source() const { return source_; }

  // nullopt: there is none of that number. Throws Error with the reason if it is there and cannot
  // be shown.
  [[nodiscard]] std::optional<StoredGame> Find(std::uint64_t number);

 private:
  // The games of a file as it was when it had this size and time.
  struct Shelf {
    std::pair<std::uintmax_t, std::filesystem::file_time_type> stamp;
    std::vector<ListedGame> games;
    std::string note;  // what could not be read
  };

  void ReadNames();
  // Brings the shelves up to date.
  void Look();
  [[nodiscard]] Shelf ReadShelf(const std::filesystem::path& file) const;
  [[nodiscard]] std::string ListSegment(const std::filesystem::path& file,
                                        std::vector<ListedGame>& games) const;
  [[nodiscard]] ListedGame Listed(const GameRecord& record) const;
  [[nodiscard]] const ListedGame* Entry(std::uint64_t number) const;
  // A file is read on from the game before, if that was an earlier one of it.
  [[nodiscard]] StoredGame ReadRecorded(const ListedGame& entry);

  const std::string source_;
  const bool run_;
  std::mutex mutex_;  // guards what follows
  std::vector<std::string> player_names_;
  std::vector<std::string> lineup_names_;
  std::string names_note_;  // why there are no names
  std::map<std::filesystem::path, Shelf> shelves_;
  int unread_ = 0;  // older segments
  GameSource reader_;
  std::uint64_t next_ = 0;  // number of the game that reader_ gives next
};

}  // namespace powderkeg

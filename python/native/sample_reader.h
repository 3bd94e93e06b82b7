#pragma once

// Stored games as training samples, a batch at a time.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/record/game_record.h"
#include "common/recorded/recorded_game.h"
#include "learner/replay/lessons.h"

namespace powderkeg {

struct TicketedSample {
  Sample sample;
  std::uint64_t ticket;  // of its game; of recorded games the number within the file
  GameSettings settings;
};

// The samples of one file, game by game as MakeLessons gives them: a segment (.h5), of whose games
// the records are held in memory, 16 bytes a decision; or recorded games (.jsonl, .jsonl.gz), one
// at a time. One thread.
class SampleReader {
 public:
  // Throws Error that names the file if it cannot be read at all, or is of another format.
  explicit SampleReader(const std::filesystem::path& path);

  // The next ones, at most `count` (> 0); none at the end. Throws Error on a recorded game that
  // cannot be read.
  [[nodiscard]] std::vector<TicketedSample> Next(std::size_t count);

  // What was left out so far, and why; empty: nothing.
  [[nodiscard]] const std::vector<std::string>& damages() const { return damages_; }

 private:
  // The lessons of the next game join those at hand; false at the end.
  bool ReadGame();
  void Take(std::variant<Lessons, std::string>&& lessons, const GameSettings& settings,
            std::uint64_t ticket);

  std::string name_;
  std::unique_ptr<RecordedGameReader> recorded_;  // or null
  std::vector<GameRecord> records_;
  std::size_t next_game_ = 0;
  std::deque<TicketedSample> samples_;
  std::vector<std::string> damages_;
};

}  // namespace powderkeg

#pragma once

// The running result of a match on a terminal or in a log.

#include <chrono>
#include <cstdint>
#include <optional>
#include <ostream>
#include <string>

#include "actors/arena/match.h"
#include "actors/arena/question.h"
#include "common/base/stats.h"

namespace powderkeg {

// On a terminal one line that is written over, at most ten times a second; elsewhere plain lines,
// at most one in ten seconds. One thread at a time.
class MatchProgress {
 public:
  enum class Style : std::uint8_t { kTerminal, kPlain };
  using Clock = std::chrono::steady_clock;

  // `out` must outlive it.
  MatchProgress(std::ostream& out, Style style, std::string title, int games);

  // Play starts, or goes on after Pause.
  void Start(Clock::time_point now);
  // Counts a finished game and shows the state if it is time.
  void AddGame(const PlayedGame& game, Clock::time_point now);
  // From now on the line shows how far the test has come.
  void SetTest(const TestState& test) { test_ = test; }
  // Others play for a while, or this was all. Ends the line on a terminal.
  void Pause(Clock::time_point now);

 private:
  [[nodiscard]] std::string Line(Clock::time_point now) const;
  void Show(Clock::time_point now);

  std::ostream& out_;
  Style style_;
  std::string title_;
  int games_;
  Clock::duration played_{};  // before start_
  Clock::time_point start_;
  Clock::time_point shown_;
  MatchScore score_;
  std::optional<TestState> test_;
};

}  // namespace powderkeg

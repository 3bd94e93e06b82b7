#pragma once

// Questions that a match may answer before its last game: Wald's sequential probability ratio test.

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/stats.h"

namespace powderkeg {

// Is the figure `low` or `high`?
struct Question {
  enum class Figure : std::uint8_t {
    kWinRate,          // of an agent
    kScoreDifference,  // of the second agent over the first on the same boards, in points per game
                       // (win 1, tie 1/2, loss 0)
  };
  Figure figure = Figure::kWinRate;
  double low = 0;
  double high = 0;
  std::string text;     // as written
  double alpha = 0.05;  // probability to answer `high` where `low` is true
  double beta = 0.05;   // probability to answer `low` where `high` is true
};

// Reads FIGURE=LOW..HIGH: win_rate=0.5..0.6 or score_difference=0..0.05. Throws Error with what is
// wrong and what is expected.
[[nodiscard]] Question ParseQuestion(std::string_view text);

enum class Answer : std::uint8_t { kOpen, kLow, kHigh };

// How far the test of a question has come.
struct TestState {
  Question question;
  Answer answer = Answer::kOpen;
  std::uint64_t games = 0;
  double log_likelihood_ratio = 0;  // of `high` over `low`
  Interval bounds;                  // `low` is answered at or below, `high` at or above
};

// "win_rate=0.5..0.6: 0.6 after 230 games (log likelihood ratio +2.96 of -2.94, +2.94)".
[[nodiscard]] std::string ToText(const TestState& state);

// The win rate is tested by the exact likelihood of wins. The score difference is tested by the
// normal approximation n (high - low) (2 mean - low - high) / (2 variance) (the generalised test of
// engine matches), its variance taken as if two more games had differed by 1, one each way: games
// without any difference then speak for `low` rather than for nothing. A value.
class SequentialTest {
 public:
  // No answer before `min_games` games.
  SequentialTest(Question question, int min_games);

  // Counts a game: 1 for a win and 0 else, or the score difference. Not after an answer.
  Answer Add(double sample);

  [[nodiscard]] const TestState& state() const { return state_; }

 private:
  [[nodiscard]] double LogLikelihoodRatio() const;

  int min_games_;
  RunningStatistics samples_;
  TestState state_;
};

}  // namespace powderkeg

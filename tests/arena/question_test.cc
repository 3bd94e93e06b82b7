#include "actors/arena/question.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "common/base/check.h"
#include "common/base/rng.h"

namespace powderkeg {
namespace {

using ::testing::HasSubstr;

TEST(ParseQuestion, ReadsBothFigures) {
  const Question rate = ParseQuestion("win_rate=0.5..0.6");
  EXPECT_EQ(rate.figure, Question::Figure::kWinRate);
  EXPECT_EQ(rate.low, 0.5);
  EXPECT_EQ(rate.high, 0.6);
  EXPECT_EQ(rate.text, "win_rate=0.5..0.6");
  const Question difference = ParseQuestion("score_difference=-0.1..0");
  EXPECT_EQ(difference.figure, Question::Figure::kScoreDifference);
  EXPECT_EQ(difference.low, -0.1);
  EXPECT_EQ(difference.high, 0);
}

TEST(ParseQuestion, RefusesWhatCannotBeAsked) {
  for (const char* text :
       {"", "win_rate", "win_rate=0.5", "win_rate=..", "win_rate=0.5..", "win_rate=0.5..0.5",
        "win_rate=0.6..0.5", "win_rate=0..0.5", "win_rate=0.5..1", "win_rate=nan..0.5",
        "win_rate=0.5..0.6x", "draws=0.1..0.2", "0.1..0.2=win_rate", "score_difference=0..1.5"}) {
    try {
      (void)ParseQuestion(text);
      FAIL() << text;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr(text));
      EXPECT_THAT(error.what(), HasSubstr("expected win_rate=LOW..HIGH"));
    }
  }
}

TEST(SequentialTest, HasWaldsRatioAndBounds) {
  SequentialTest test(ParseQuestion("win_rate=0.5..0.6"), /*min_games=*/1);
  test.Add(1);
  EXPECT_DOUBLE_EQ(test.state().log_likelihood_ratio, std::log(0.6 / 0.5));
  test.Add(0);
  EXPECT_DOUBLE_EQ(test.state().log_likelihood_ratio, std::log(1.2) + std::log(0.8));
  EXPECT_DOUBLE_EQ(test.state().bounds.high, std::log(19));
  EXPECT_DOUBLE_EQ(test.state().bounds.low, -std::log(19));
  EXPECT_EQ(test.state().answer, Answer::kOpen);
}

TEST(SequentialTest, HasTheGeneralisedRatio) {
  SequentialTest test(ParseQuestion("score_difference=0..0.1"), /*min_games=*/1);
  test.Add(0.5);
  test.Add(0);
  // Mean 1/4, squares 1/8: variance (1/8 + 2) / 4.
  EXPECT_DOUBLE_EQ(test.state().log_likelihood_ratio, 2 * 0.1 * (0.5 - 0.1) / (2 * 2.125 / 4));
}

TEST(SequentialTest, AnswersNothingBeforeTheFirstGamesAreOver) {
  SequentialTest test(ParseQuestion("win_rate=0.5..0.6"), /*min_games=*/30);
  for (int i = 0; i < 29; ++i) ASSERT_EQ(test.Add(1), Answer::kOpen);
  EXPECT_GT(test.state().log_likelihood_ratio, test.state().bounds.high);
  EXPECT_EQ(test.Add(1), Answer::kHigh);
  EXPECT_EQ(test.state().games, 30u);
}

TEST(SequentialTest, OfEqualAgentsAnswersNoDifference) {
  SequentialTest test(ParseQuestion("score_difference=0..0.05"), /*min_games=*/20);
  int games = 0;
  while (test.state().answer == Answer::kOpen && games < 500) {
    test.Add(0);
    ++games;
  }
  EXPECT_EQ(test.state().answer, Answer::kLow);
  EXPECT_LT(games, 100);
}

TEST(SequentialTest, SaysHowItWasDecided) {
  SequentialTest test(ParseQuestion("win_rate=0.5..0.6"), /*min_games=*/3);
  test.Add(1);
  EXPECT_EQ(ToText(test.state()),
            "win_rate=0.5..0.6: open after 1 games (log likelihood ratio +0.18 of -2.94, +2.94)");
  while (test.Add(1) == Answer::kOpen) {
  }
  EXPECT_EQ(ToText(test.state()),
            "win_rate=0.5..0.6: 0.6 after 17 games (log likelihood ratio +3.10 of -2.94, +2.94)");
}

struct Rates {
  double low = 0;  // share of tests that answered it
  double high = 0;
  double games = 0;  // mean until the answer
};

// Plays the test many times over with samples of one kind.
Rates Simulate(const char* question, const std::function<double(Rng&)>& sample) {
  constexpr int kTests = 2000;
  Rates rates;
  for (int i = 0; i < kTests; ++i) {
    Rng rng = Rng(11).Split(static_cast<std::uint64_t>(i));
    SequentialTest test(ParseQuestion(question), /*min_games=*/50);
    while (test.Add(sample(rng)) == Answer::kOpen) {
    }
    (test.state().answer == Answer::kHigh ? rates.high : rates.low) += 1.0 / kTests;
    rates.games += static_cast<double>(test.state().games) / kTests;
  }
  return rates;
}

std::function<double(Rng&)> WinsWith(double probability) {
  return [probability](Rng& rng) { return rng.Uniform() < probability ? 1.0 : 0.0; };
}

// Half a point, or a whole one, more or less in most games.
std::function<double(Rng&)> DiffersBy(double mean) {
  return [mean](Rng& rng) {
    const double sign = rng.Uniform() < 0.5 + mean / (2 * 0.625) ? 1 : -1;
    return sign * (rng.Uniform() < 0.5 ? 1.0 : rng.Uniform() < 0.5 ? 0.5 : 0.0);
  };
}

// Wald: each wrong answer in at most about 5 %, in far fewer games than a fixed match needs (which
// is 267 for these).
TEST(SequentialTest, KeepsItsErrorRatesOfWinRates) {
  const Rates low = Simulate("win_rate=0.5..0.6", WinsWith(0.5));
  EXPECT_LT(low.high, 0.06);
  EXPECT_GT(low.high, 0.02);
  EXPECT_LT(low.games, 160);
  const Rates high = Simulate("win_rate=0.5..0.6", WinsWith(0.6));
  EXPECT_LT(high.low, 0.06);
  EXPECT_GT(high.low, 0.02);
  EXPECT_LT(high.games, 160);
  EXPECT_LT(Simulate("win_rate=0.5..0.6", WinsWith(0.7)).low, 0.002);
}

TEST(SequentialTest, KeepsItsErrorRatesOfScoreDifferences) {
  const Rates low = Simulate("score_difference=0..0.1", DiffersBy(0));
  EXPECT_LT(low.high, 0.06);
  EXPECT_GT(low.high, 0.02);
  const Rates high = Simulate("score_difference=0..0.1", DiffersBy(0.1));
  EXPECT_LT(high.low, 0.06);
  EXPECT_GT(high.low, 0.02);
}

}  // namespace
}  // namespace powderkeg

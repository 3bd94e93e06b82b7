#include "actors/arena/question.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include "common/base/check.h"
#include "common/base/number.h"

namespace powderkeg {
namespace {

constexpr std::string_view kExpected =
    "expected win_rate=LOW..HIGH with 0 < LOW < HIGH < 1 or score_difference=LOW..HIGH with "
    "-1 <= LOW < HIGH <= 1";

[[noreturn]] void Refuse(std::string_view text) {
  throw Error(StrCat("question \"", text, "\": ", kExpected));
}

std::optional<Question::Figure> FigureFor(std::string_view name) {
  if (name == "win_rate") return Question::Figure::kWinRate;
  if (name == "score_difference") return Question::Figure::kScoreDifference;
  return std::nullopt;
}

bool IsAskable(const Question& question) {
  if (question.figure == Question::Figure::kWinRate) {
    return 0 < question.low && question.low < question.high && question.high < 1;
  }
  return -1 <= question.low && question.low < question.high && question.high <= 1;
}

}  // namespace

Question ParseQuestion(std::string_view text) {
  const std::size_t equals = text.find('=');
  const std::size_t dots = text.find("..");
  if (equals == std::string_view::npos || dots == std::string_view::npos || dots < equals) {
    Refuse(text);
  }
  const auto figure = FigureFor(text.substr(0, equals));
  const auto low = ParseNumber<double>(text.substr(equals + 1, dots - equals - 1));
  const auto high = ParseNumber<double>(text.substr(dots + 2));
  if (!figure || !low || !high) Refuse(text);
  Question question{.figure = *figure, .low = *low, .high = *high, .text = std::string(text)};
  if (!IsAskable(question)) Refuse(text);
  return question;
}

std::string ToText(const TestState& state) {
  const std::string verdict =
      state.answer == Answer::kOpen
          ? "open"
          : StrCat(state.answer == Answer::kHigh ? state.question.high : state.question.low);
  std::array<char, 120> ratio;
  std::snprintf(ratio.data(), ratio.size(), "(log likelihood ratio %+.2f of %+.2f, %+.2f)",
                state.log_likelihood_ratio, state.bounds.low, state.bounds.high);
  return StrCat(state.question.text, ": ", verdict, " after ", state.games, " games ",
                ratio.data());
}

SequentialTest::SequentialTest(Question question, int min_games) : min_games_(min_games) {
  state_.question = std::move(question);
  const double alpha = state_.question.alpha;
  const double beta = state_.question.beta;
  state_.bounds = {std::log(beta / (1 - alpha)), std::log((1 - beta) / alpha)};
}

Answer SequentialTest::Add(double sample) {
  CHECK(state_.answer == Answer::kOpen);
  samples_.Add(sample);
  state_.games = samples_.count();
  state_.log_likelihood_ratio = LogLikelihoodRatio();
  if (samples_.count() < static_cast<std::uint64_t>(min_games_)) return Answer::kOpen;
  if (state_.log_likelihood_ratio <= state_.bounds.low) state_.answer = Answer::kLow;
  if (state_.log_likelihood_ratio >= state_.bounds.high) state_.answer = Answer::kHigh;
  return state_.answer;
}

double SequentialTest::LogLikelihoodRatio() const {
  const double low = state_.question.low;
  const double high = state_.question.high;
  const double n = static_cast<double>(samples_.count());
  const double mean = samples_.mean();
  if (state_.question.figure == Question::Figure::kWinRate) {
    return n * (mean * std::log(high / low) + (1 - mean) * std::log((1 - high) / (1 - low)));
  }
  const double variance = (samples_.variance() * (n - 1) + 2) / (n + 2);
  return n * (high - low) * (2 * mean - low - high) / (2 * variance);
}

}  // namespace powderkeg

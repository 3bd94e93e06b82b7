#include "actors/arena/match_progress.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

namespace powderkeg {
namespace {

using namespace std::chrono_literals;

constexpr int kBarWidth = 24;

std::string Bar(int done, int total) {
  std::string bar(kBarWidth + 2, ' ');
  std::fill_n(bar.begin() + 1, kBarWidth * done / total, '=');
  bar.front() = '[';
  bar.back() = ']';
  return bar;
}

std::string TestText(const TestState& test) {
  std::array<char, 80> text;
  std::snprintf(text.data(), text.size(), "  llr %+.2f of %+.2f, %+.2f", test.log_likelihood_ratio,
                test.bounds.low, test.bounds.high);
  return text.data();
}

}  // namespace

MatchProgress::MatchProgress(std::ostream& out, Style style, std::string title, int games)
    : out_(out), style_(style), title_(std::move(title)), games_(games) {}

void MatchProgress::Start(Clock::time_point now) {
  if (style_ == Style::kPlain) out_ << title_ << ": " << games_ << " games" << std::endl;
  start_ = now;
  shown_ = now;
}

void MatchProgress::AddGame(const PlayedGame& game, Clock::time_point now) {
  const int outcome = game.outcomes[0];
  score_.Add(outcome);
  const bool last = score_.games() == static_cast<std::uint64_t>(games_);
  const auto pause = style_ == Style::kTerminal ? 100ms : 10'000ms;
  if (last || now - shown_ >= pause) Show(now);
}

void MatchProgress::Pause(Clock::time_point now) {
  played_ += now - start_;
  if (style_ == Style::kTerminal) out_ << std::endl;
}

void MatchProgress::Show(Clock::time_point now) {
  shown_ = now;
  if (style_ == Style::kTerminal) {
    out_ << '\r' << Bar(static_cast<int>(score_.games()), games_) << ' ' << Line(now) << "\x1b[K"
         << std::flush;
  } else {
    out_ << Line(now) << std::endl;
  }
}

std::string MatchProgress::Line(Clock::time_point now) const {
  const auto done = static_cast<double>(score_.games());
  const double seconds = std::chrono::duration<double>(played_ + (now - start_)).count();
  const Interval win = WilsonInterval(score_.wins, score_.games());
  std::array<char, 160> text;
  std::snprintf(text.data(), text.size(),
                "%.0f/%d  win %.3f [%.3f, %.3f]  tie %.3f  loss %.3f  %.0f s left", done, games_,
                static_cast<double>(score_.wins) / done, win.low, win.high,
                static_cast<double>(score_.ties) / done, static_cast<double>(score_.losses) / done,
                seconds / done * (games_ - done));
  return text.data() + (test_ ? TestText(*test_) : "");
}

}  // namespace powderkeg

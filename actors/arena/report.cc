#include "actors/arena/report.h"

#include <cstdio>
#include <string_view>
#include <utility>

#include "common/base/check.h"

namespace powderkeg {
namespace {

constexpr std::array<const char*, kActionCount> kActionNames = {"stop", "up",    "down",
                                                                "left", "right", "bomb"};

// printf into a string.
template <typename... Values>
std::string Format(const char* format, Values... values) {
  const int length = std::snprintf(nullptr, 0, format, values...);
  CHECK(length >= 0, format);
  std::string text(static_cast<std::size_t>(length), '\0');
  std::snprintf(text.data(), text.size() + 1, format, values...);
  return text;
}

// In quotes, with what JSON and CSV both need escaped in a file name or specification.
std::string Quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char character : text) {
    if (character == '"' || character == '\\') quoted += '\\';
    quoted += character;
  }
  return quoted + "\"";
}

double Rate(std::uint64_t count, std::uint64_t total) {
  return total == 0 ? 0.0 : static_cast<double>(count) / static_cast<double>(total);
}

SeatStatistics CandidateStatistics(const MatchSettings& settings, const Match& match) {
  SeatStatistics sum;
  for (const PlayedGame& game : match.games) {
    sum += game.statistics[0];
    if (IsTeamMode(settings.game.mode)) sum += game.statistics[2];
  }
  return sum;
}

std::string RateText(const char* name, std::uint64_t count, std::uint64_t games) {
  const Interval interval = WilsonInterval(count, games);
  return Format("  %-7s %5.3f  [%5.3f, %5.3f]  %llu\n", name, Rate(count, games), interval.low,
                interval.high, static_cast<unsigned long long>(count));
}

std::string RateJson(const char* name, std::uint64_t count, std::uint64_t games) {
  const Interval interval = WilsonInterval(count, games);
  return Format(R"("%s": %.6f, "%s_low": %.6f, "%s_high": %.6f, )", name, Rate(count, games), name,
                interval.low, name, interval.high);
}

std::string ActionsText(const MatchSummary& summary) {
  std::string text = "  actions";
  for (std::size_t action = 0; action < kActionCount; ++action) {
    text += Format("  %s %.3f", kActionNames[action], summary.action_shares[action]);
  }
  return text + "\n";
}

std::string SearchText(const MatchSummary& summary) {
  if (summary.mean_batch == 0) return "";  // nothing was ever evaluated
  std::string text = Format(
      "  depth   %5.2f   ms/move %.2f   simulations/s %.0f   mean batch %.1f\n", summary.mean_depth,
      summary.ms_per_move, summary.simulations_per_s, summary.mean_batch);
  if (summary.prediction_accuracy >= 0) {
    text += Format("  opponents' actions predicted at the root: %.1f %%\n",
                   100 * summary.prediction_accuracy);
  }
  return text;
}

std::string ContenderText(const Contender& contender) {
  const MatchSummary& summary = contender.summary;
  const std::uint64_t games = summary.score.games();
  return contender.agent + "\n" +
         Format("  %llu games in %.1f s against %s\n", static_cast<unsigned long long>(games),
                contender.match.seconds, contender.opponents.c_str()) +
         RateText("win", summary.score.wins, games) + RateText("tie", summary.score.ties, games) +
         RateText("loss", summary.score.losses, games) +
         Format("  steps   %5.1f   (sd %.1f; alive for %.1f)\n", summary.steps.mean(),
                summary.steps.standard_deviation(), summary.moves_per_game) +
         SearchText(summary) + ActionsText(summary);
}

std::string DifferenceText(const Contender& contender, const Contender& base) {
  const Difference difference = Compare(contender.match, base.match);
  return contender.agent + "\n" +
         Format(
             "  against the first, board by board: win %+.3f [%+.3f, %+.3f]"
             "   score %+.3f [%+.3f, %+.3f]\n",
             difference.win_rate, difference.win_interval.low, difference.win_interval.high,
             difference.score, difference.score_interval.low, difference.score_interval.high);
}

std::string ContenderJson(const Contender& contender) {
  const MatchSummary& summary = contender.summary;
  const std::uint64_t games = summary.score.games();
  std::string text =
      "{\"agent\": " + Quoted(contender.agent) + ", \"opponents\": " + Quoted(contender.opponents) +
      Format(R"(, "games": %llu, )", static_cast<unsigned long long>(games)) +
      RateJson("win", summary.score.wins, games) + RateJson("tie", summary.score.ties, games) +
      RateJson("loss", summary.score.losses, games) +
      Format(R"("steps": %.3f, "moves_per_game": %.3f, "depth": %.4f, "ms_per_move": %.4f, )"
             R"("simulations_per_s": %.1f, "mean_batch": %.3f, "seconds": %.3f, )",
             summary.steps.mean(), summary.moves_per_game, summary.mean_depth, summary.ms_per_move,
             summary.simulations_per_s, summary.mean_batch, contender.match.seconds);
  if (summary.prediction_accuracy >= 0) {
    text += Format(R"("prediction_accuracy": %.5f, )", summary.prediction_accuracy);
  }
  text += "\"actions\": {";
  for (std::size_t action = 0; action < kActionCount; ++action) {
    text += Format(R"(%s"%s": %.5f)", action == 0 ? "" : ", ", kActionNames[action],
                   summary.action_shares[action]);
  }
  return text + "}}";
}

}  // namespace

MatchSummary Summarize(const MatchSettings& settings, const Match& match) {
  MatchSummary summary;
  for (const PlayedGame& game : match.games) {
    const int outcome = game.outcomes[0];
    ++(outcome > 0 ? summary.score.wins : outcome < 0 ? summary.score.losses : summary.score.ties);
    summary.steps.Add(game.steps);
  }
  const SeatStatistics candidate = CandidateStatistics(settings, match);
  summary.moves_per_game = Rate(candidate.moves, match.games.size());
  summary.mean_batch = match.metrics.mean_batch();
  for (std::size_t action = 0; action < kActionCount; ++action) {
    summary.action_shares[action] = Rate(candidate.actions[action], candidate.moves);
  }
  if (candidate.moves > 0) summary.ms_per_move = 1e3 * match.thread_seconds / candidate.moves;
  if (candidate.searches > 0) summary.mean_depth = candidate.depth_sum / candidate.searches;
  if (match.seconds > 0) {
    summary.simulations_per_s = static_cast<double>(match.metrics.simulations) / match.seconds;
  }
  if (candidate.predictions > 0) {
    summary.prediction_accuracy = Rate(candidate.predictions_right, candidate.predictions);
  }
  return summary;
}

Difference Compare(const Match& candidate, const Match& base) {
  CHECK(candidate.games.size() == base.games.size());
  RunningStatistics wins;
  RunningStatistics points;
  for (std::size_t i = 0; i < base.games.size(); ++i) {
    const int ours = candidate.games[i].outcomes[0];
    const int theirs = base.games[i].outcomes[0];
    wins.Add((ours > 0 ? 1 : 0) - (theirs > 0 ? 1 : 0));
    points.Add(0.5 * (ours - theirs));
  }
  return {wins.mean(), wins.MeanInterval(), points.mean(), points.MeanInterval()};
}

std::string ReportText(std::span<const Contender> contenders) {
  std::string text;
  for (const Contender& contender : contenders) text += ContenderText(contender) + "\n";
  for (std::size_t i = 1; i < contenders.size(); ++i) {
    text += DifferenceText(contenders[i], contenders[0]);
  }
  return text;
}

std::string ReportJson(std::span<const Contender> contenders) {
  std::string text = "{\"contenders\": [\n";
  for (std::size_t i = 0; i < contenders.size(); ++i) {
    text += ContenderJson(contenders[i]) + (i + 1 < contenders.size() ? ",\n" : "\n");
  }
  return text + "]}\n";
}

std::string ReportCsv(std::span<const Contender> contenders) {
  std::string text = "agent,game,seed,seat,outcome,steps,moves,simulations\n";
  for (const Contender& contender : contenders) {
    for (const PlayedGame& game : contender.match.games) {
      const SeatStatistics& statistics = game.statistics[0];
      text +=
          Quoted(contender.agent) + Format(",%d,%llu,%d,%d,%d,%u,%llu\n", game.number,
                                           static_cast<unsigned long long>(game.seed), game.seat,
                                           game.outcomes[0], game.steps, statistics.moves,
                                           static_cast<unsigned long long>(statistics.simulations));
    }
  }
  return text;
}

}  // namespace powderkeg

#include "actors/arena/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/base/format.h"
#include "common/base/rating.h"

namespace powderkeg {
namespace {

// In quotes, with what JSON and CSV both need escaped in a file name or specification.
std::string Escaped(std::string_view text) {
  std::string quoted = "\"";
  for (const char character : text) {
    if (character == '"' || character == '\\') quoted += '\\';
    quoted += character;
  }
  return quoted + "\"";
}

double RateOf(std::uint64_t count, std::uint64_t total) {
  return static_cast<double>(count) / static_cast<double>(total);
}

// For people.

std::string RateText(const char* name, std::uint64_t count, std::uint64_t games) {
  const Interval interval = WilsonInterval(count, games);
  return Format("  %-7s %5.3f  [%5.3f, %5.3f]  %llu\n", name, RateOf(count, games), interval.low,
                interval.high, static_cast<unsigned long long>(count));
}

std::string EloText(const EloEstimate& elo) {
  return Format("%+.0f [%+.0f, %+.0f]", elo.elo, elo.interval.low, elo.interval.high);
}

std::string ActionsText(const MatchSummary& summary) {
  std::string text = "  actions";
  for (std::size_t action = 0; action < kActionCount; ++action) {
    text += Format("  %s %.3f", kActionNames[action], summary.action_shares[action]);
  }
  return text + "\n";
}

std::string ActsText(const MatchSummary& summary) {
  std::string text = Format("  a game  bombs %.2f  kicks %.2f  kills %.2f  own deaths %.3f",
                            summary.bombs_per_game, summary.kicks_per_game, summary.kills_per_game,
                            summary.own_deaths_per_game);
  if (summary.mate_kills_per_game > 0) {
    text += Format("  mates killed %.3f", summary.mate_kills_per_game);
  }
  return text + Format("  cells in 20 steps %.2f\n", summary.cells_in_window);
}

std::string TakenForText(const MatchSummary& summary) {
  std::string text = "  opponents taken for";
  for (std::size_t model = 0; model < kOpponentModelCount; ++model) {
    if (summary.taken_for[model] == 0) continue;
    text += Format("  %s %.3f", std::string(NamesOf(OpponentModel{})[model]).c_str(),
                   summary.taken_for[model]);
  }
  return text + "\n";
}

std::string SearchText(const MatchSummary& summary) {
  if (summary.mean_batch == 0) return "";  // nothing was ever evaluated
  std::string text = Format(
      "  depth   %5.2f   variation %.2f   ms/move %.2f   simulations/s %.0f   mean batch %.1f\n",
      summary.mean_depth, summary.variation_length, summary.ms_per_move, summary.simulations_per_s,
      summary.mean_batch);
  if (summary.prediction_accuracy >= 0) {
    text += Format("  opponents' actions predicted at the root: %.1f %%\n",
                   100 * summary.prediction_accuracy);
    text += TakenForText(summary);
  }
  return text;
}

// The moves that servers missed: whom they beat, and who beats them, is then not quite what it
// seems.
std::string LateText(const Contender& contender) {
  std::string text;
  for (std::size_t role = 0; role < contender.roles.size(); ++role) {
    SeatStatistics sum;
    for (const PlayedGame& game : contender.match.games) sum += game.statistics[role];
    if (sum.late_moves == 0) continue;
    text += Format("  late    %u of %u moves of ", sum.late_moves, sum.moves) +
            contender.roles[role] + ", instead of which it stopped\n";
  }
  return text;
}

std::string DifferenceText(const Difference& difference) {
  return Format(
             "  against the first, board by board: win %+.3f [%+.3f, %+.3f]"
             "   score %+.3f [%+.3f, %+.3f]   Elo ",
             difference.win_rate, difference.win_interval.low, difference.win_interval.high,
             difference.score, difference.score_interval.low, difference.score_interval.high) +
         EloText(difference.elo) + "\n";
}

std::string ContenderText(const Contender& contender) {
  const MatchSummary& summary = contender.summary;
  const std::uint64_t games = summary.score.games();
  std::string text =
      contender.agent + "\n" +
      Format("  %llu games in %.1f s against %s\n", static_cast<unsigned long long>(games),
             contender.match.seconds, contender.opponents.c_str()) +
      RateText("win", summary.score.wins, games) + RateText("tie", summary.score.ties, games) +
      RateText("loss", summary.score.losses, games) +
      RateText("died", summary.deaths, summary.agents) + "  Elo     " + EloText(summary.elo) +
      "  over the average opponent\n" +
      Format("  steps   %5.1f   (sd %.1f; alive for %.1f)\n", summary.steps.mean(),
             summary.steps.standard_deviation(), summary.moves_per_game) +
      SearchText(summary) + LateText(contender) + ActionsText(summary) + ActsText(summary);
  if (contender.difference) text += DifferenceText(*contender.difference);
  if (contender.test) text += "  question " + ToText(*contender.test) + "\n";
  return text;
}

std::string TableText(std::span<const Contender> contenders) {
  std::string text =
      "   win   [95 %]            tie    loss    died    Elo   steps  depth  ms/move   stop  bombs"
      "  kicks  kills  cells  agent\n";
  for (const Contender& contender : contenders) {
    const MatchSummary& summary = contender.summary;
    const std::uint64_t games = summary.score.games();
    const Interval win = WilsonInterval(summary.score.wins, games);
    text += Format(
        "%6.3f [%5.3f, %5.3f]  %6.3f  %6.3f  %6.3f  %+5.0f  %6.1f  %5.2f  %7.2f  %5.3f  %5.2f  "
        "%5.2f  %5.2f  %5.2f  %s\n",
        RateOf(summary.score.wins, games), win.low, win.high, RateOf(summary.score.ties, games),
        RateOf(summary.score.losses, games), RateOf(summary.deaths, summary.agents),
        summary.elo.elo, summary.steps.mean(), summary.mean_depth, summary.ms_per_move,
        summary.action_shares[0], summary.bombs_per_game, summary.kicks_per_game,
        summary.kills_per_game, summary.cells_in_window, contender.agent.c_str());
  }
  return text;
}

// A figure over models: its mean, and the standard deviation between them.
std::string SpreadText(const char* name, std::span<const Contender* const> models,
                       const std::function<double(const MatchSummary&)>& figure) {
  RunningStatistics values;
  for (const Contender* model : models) values.Add(figure(model->summary));
  return Format("  %-9s %7.3f +- %.3f", name, values.mean(), values.standard_deviation());
}

// The same of games that ended in some way, beside the interval of all games together.
std::string RateSpreadText(const char* name, std::span<const Contender* const> models,
                           std::uint64_t MatchScore::*count) {
  std::uint64_t pooled = 0;
  std::uint64_t games = 0;
  for (const Contender* model : models) {
    pooled += model->summary.score.*count;
    games += model->summary.score.games();
  }
  const Interval interval = WilsonInterval(pooled, games);
  return SpreadText(name, models,
                    [count](const MatchSummary& summary) {
                      return RateOf(summary.score.*count, summary.score.games());
                    }) +
         Format("   of %llu games %.3f [%.3f, %.3f]\n", static_cast<unsigned long long>(games),
                RateOf(pooled, games), interval.low, interval.high);
}

std::string ModelsText(std::span<const Contender> contenders) {
  std::map<std::string, std::vector<const Contender*>> series;
  for (const Contender& contender : contenders) {
    if (!contender.settings.empty()) series[contender.settings].push_back(&contender);
  }
  std::string text;
  for (const auto& [settings, models] : series) {
    text += StrCat("\n", settings, ", mean +- standard deviation between ", models.size(),
                   " models\n") +
            RateSpreadText("win", models, &MatchScore::wins) +
            RateSpreadText("tie", models, &MatchScore::ties) +
            RateSpreadText("loss", models, &MatchScore::losses) +
            SpreadText("steps", models, [](const auto& summary) { return summary.steps.mean(); }) +
            SpreadText("depth", models, [](const auto& summary) { return summary.mean_depth; }) +
            SpreadText("variation", models,
                       [](const auto& summary) { return summary.variation_length; }) +
            SpreadText("ms/move", models, [](const auto& summary) { return summary.ms_per_move; }) +
            "\n";
  }
  return text;
}

Place PlaceOf(const Contender& contender, const PlayedGame& game, std::size_t role) {
  const auto lasted = static_cast<int>(game.statistics[role].moves);
  return {.won = game.outcomes[role] > 0, .lasted = contender.teams ? 0 : lasted};
}

// Everybody of a match against everybody else in it.
void AddPairs(const Contender& contender, NamedScores& pairs) {
  const auto& roles = contender.roles;
  for (std::size_t second = 1; second < roles.size(); ++second) {
    for (std::size_t first = 0; first < second; ++first) {
      const bool mates = contender.teams && second - first == 2;
      if (mates || roles[first] == roles[second] || roles[second].empty()) continue;
      const bool ordered = roles[first] < roles[second];
      const auto [a, b] = ordered ? std::pair(first, second) : std::pair(second, first);
      MatchScore& score = pairs[{roles[a], roles[b]}];
      for (const PlayedGame& game : contender.match.games) {
        score.Add(Compare(PlaceOf(contender, game, a), PlaceOf(contender, game, b)));
      }
    }
  }
}

std::string RatingsText(std::span<const Contender> contenders) {
  NamedScores pairs;
  for (const Contender& contender : contenders) AddPairs(contender, pairs);
  const std::vector<RatedName> rated = RateNames(pairs);
  if (rated.size() <= 2) return "";
  std::string text = "\nrating  [95 %]           pairs  from who outlived whom\n";
  for (const auto& [name, games, rating] : rated) {
    text +=
        Format("%+6.0f  [%+5.0f, %+5.0f]  %8.0f  ", rating.elo, rating.elo - rating.half_interval,
               rating.elo + rating.half_interval, static_cast<double>(games)) +
        name + "\n";
  }
  return text;
}

// For programs.

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

struct Figure {
  std::string name;
  double value;  // not finite: none
};

void AddRate(const std::string& name, std::uint64_t count, std::uint64_t games,
             std::vector<Figure>& figures) {
  const Interval interval = WilsonInterval(count, games);
  figures.push_back({name, RateOf(count, games)});
  figures.push_back({name + "_low", interval.low});
  figures.push_back({name + "_high", interval.high});
}

void AddInterval(const std::string& name, double value, const Interval& interval,
                 std::vector<Figure>& figures) {
  figures.push_back({name, value});
  figures.push_back({name + "_low", interval.low});
  figures.push_back({name + "_high", interval.high});
}

void AddDifference(const std::optional<Difference>& difference, std::vector<Figure>& figures) {
  constexpr Interval kNone{kUnknown, kUnknown};
  const Difference d =
      difference.value_or(Difference{kUnknown, kNone, kUnknown, kNone, {kUnknown, kNone}});
  AddInterval("win_difference", d.win_rate, d.win_interval, figures);
  AddInterval("score_difference", d.score, d.score_interval, figures);
  AddInterval("elo_difference", d.elo.elo, d.elo.interval, figures);
}

// Every number of a contender but the heat map.
std::vector<Figure> FiguresOf(const Contender& contender) {
  const MatchSummary& summary = contender.summary;
  const std::uint64_t games = summary.score.games();
  std::vector<Figure> figures = {{"simulations", static_cast<double>(contender.simulations)},
                                 {"games", static_cast<double>(games)}};
  AddRate("win", summary.score.wins, games, figures);
  AddRate("tie", summary.score.ties, games, figures);
  AddRate("loss", summary.score.losses, games, figures);
  AddRate("died", summary.deaths, summary.agents, figures);
  AddInterval("elo", summary.elo.elo, summary.elo.interval, figures);
  const std::vector<Figure> plain = {
      {"steps", summary.steps.mean()},
      {"moves_per_game", summary.moves_per_game},
      {"depth", summary.mean_depth},
      {"variation_length", summary.variation_length},
      {"ms_per_move", summary.ms_per_move},
      {"simulations_per_s", summary.simulations_per_s},
      {"mean_batch", summary.mean_batch},
      {"seconds", contender.match.seconds},
      {"prediction_accuracy",
       summary.prediction_accuracy >= 0 ? summary.prediction_accuracy : kUnknown},
      {"bombs", summary.bombs_per_game},
      {"kicks", summary.kicks_per_game},
      {"kills", summary.kills_per_game},
      {"mate_kills", summary.mate_kills_per_game},
      {"own_deaths", summary.own_deaths_per_game},
      {"cells_in_20_steps", summary.cells_in_window}};
  figures.insert(figures.end(), plain.begin(), plain.end());
  for (std::size_t action = 0; action < kActionCount; ++action) {
    figures.push_back(
        {std::string("share_") + kActionNames[action], summary.action_shares[action]});
  }
  for (std::size_t model = 0; model < kOpponentModelCount; ++model) {
    figures.push_back(
        {StrCat("taken_for_", NamesOf(OpponentModel{})[model]), summary.taken_for[model]});
  }
  AddDifference(contender.difference, figures);
  return figures;
}

std::string Number(double value, const char* none) {
  return std::isfinite(value) ? Format("%.7g", value) : none;
}

std::string QuestionJson(const TestState& test) {
  const Question& question = test.question;
  const std::string answer =
      test.answer == Answer::kOpen
          ? "open"
          : Number(test.answer == Answer::kHigh ? question.high : question.low, "");
  return Format(R"(, "question": %s, "answer": "%s", "log_likelihood_ratio": %.4f)",
                Escaped(question.text).c_str(), answer.c_str(), test.log_likelihood_ratio);
}

std::string HeatMapJson(const MatchSummary& summary) {
  std::string text = "[";
  for (Cell cell = 0; cell < kCellCount; ++cell) {
    const bool row_starts = ColumnOf(cell) == 0;
    text += row_starts ? (cell == 0 ? "[" : "], [") : ", ";
    text += StrCat(summary.heat_map[cell]);
  }
  return text + "]]";
}

std::string ContenderJson(const Contender& contender) {
  std::string text = "{\"agent\": " + Escaped(contender.agent) +
                     ", \"opponents\": " + Escaped(contender.opponents);
  for (const Figure& figure : FiguresOf(contender)) {
    text += ", \"" + figure.name + "\": " + Number(figure.value, "null");
  }
  if (!contender.settings.empty()) text += ", \"settings\": " + Escaped(contender.settings);
  if (contender.test) text += QuestionJson(*contender.test);
  return text + ", \"heat_map\": " + HeatMapJson(contender.summary) + "}";
}

// The agent without the number of its simulations.
std::string SeriesName(std::string agent) {
  const std::size_t start = agent.find("simulations=");
  if (start == std::string::npos) return agent;
  const std::size_t comma = agent.find(',', start);
  agent.erase(start, comma == std::string::npos ? comma : comma + 1 - start);
  if (agent.ends_with(',') || agent.ends_with(':')) agent.pop_back();
  return agent;
}

std::size_t SeriesOf(std::span<const Contender> contenders, const Contender& contender) {
  const auto first = std::ranges::find_if(contenders, [&](const Contender& other) {
    return SeriesName(other.agent) == SeriesName(contender.agent);
  });
  return static_cast<std::size_t>(first - contenders.begin());
}

std::string TableHeader(const Contender& contender) {
  std::string text = "number,series";
  for (const Figure& figure : FiguresOf(contender)) text += "," + figure.name;
  for (Cell cell = 0; cell < kCellCount; ++cell) text += Format(",cell_%d", cell);
  return text + ",agent,opponents\n";
}

}  // namespace

std::string ReportText(std::span<const Contender> contenders) {
  std::string text;
  for (const Contender& contender : contenders) text += ContenderText(contender) + "\n";
  if (contenders.size() > 1) text += TableText(contenders);
  return text + ModelsText(contenders) + RatingsText(contenders);
}

std::string ReportJson(std::span<const Contender> contenders) {
  std::string text = "{\"contenders\": [\n";
  for (std::size_t i = 0; i < contenders.size(); ++i) {
    text += ContenderJson(contenders[i]) + (i + 1 < contenders.size() ? ",\n" : "\n");
  }
  return text + "]}\n";
}

std::string TableCsv(std::span<const Contender> contenders) {
  std::string text;
  for (std::size_t i = 0; i < contenders.size(); ++i) {
    const Contender& contender = contenders[i];
    if (i == 0) text += TableHeader(contender);
    text += StrCat(i, ",", SeriesOf(contenders, contender));
    for (const Figure& figure : FiguresOf(contender)) text += "," + Number(figure.value, "");
    for (const std::uint64_t moves : contender.summary.heat_map) text += StrCat(",", moves);
    text += "," + Escaped(contender.agent) + "," + Escaped(contender.opponents) + "\n";
  }
  return text;
}

std::string GamesCsv(std::span<const Contender> contenders) {
  std::string text =
      "agent,game,seed,seat,outcome,died,steps,moves,simulations,bombs,kicks,kills,own_deaths\n";
  for (const Contender& contender : contenders) {
    for (const PlayedGame& game : contender.match.games) {
      const SeatStatistics& statistics = game.statistics[0];
      text += Escaped(contender.agent) +
              Format(",%d,%llu,%d,%d,%d,%d,%u,%llu,%u,%u,%u,%u\n", game.number,
                     static_cast<unsigned long long>(game.seed), game.seat, game.outcomes[0],
                     game.died[0] ? 1 : 0, game.steps, statistics.moves,
                     static_cast<unsigned long long>(statistics.simulations), statistics.bombs,
                     statistics.kicks, statistics.kills, statistics.own_deaths);
    }
  }
  return text;
}

}  // namespace powderkeg

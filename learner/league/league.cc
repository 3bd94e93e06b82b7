#include "learner/league/league.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <ranges>

#include "common/base/check.h"
#include "common/base/number.h"
#include "common/record/game_setup.h"

namespace powderkeg {
namespace {

MatchScore Mirrored(const MatchScore& score) {
  return {.wins = score.losses, .ties = score.ties, .losses = score.wins};
}

Place PlaceOf(const GameResult& result, AgentId agent) {
  const Finish& finish = result.finishes[agent];
  return {.won = result.outcome.Won(agent), .lasted = finish.mate >= 0 ? 0 : finish.lasted};
}

// What Contestant::name() wrote.
Contestant Named(const std::string& name) {
  if (name.starts_with("v")) {
    if (const auto version = ParseNumber<std::uint32_t>(std::string_view(name).substr(1))) {
      return {.player = "", .version = *version};
    }
  }
  return {.player = name};
}

}  // namespace

std::string Contestant::name() const { return version == 0 ? player : StrCat("v", version); }

League::League(const std::filesystem::path& file, std::vector<std::string> players,
               int iterations_done)
    : file_{.path = file, .first = "first", .second = "second"},
      players_(std::move(players)),
      rows_(file_.Read(iterations_done)) {
  for (const auto& [key, score] : rows_) {
    totals_[{Named(std::get<1>(key)), Named(std::get<2>(key))}] += score;
  }
}

void League::Add(int iteration, std::span<const GameResult> results) {
  std::unique_lock lock(mutex_);
  for (const GameResult& result : results) {
    for (AgentId first = 0; first < kAgentCount; ++first) {
      for (AgentId second = first + 1; second < kAgentCount; ++second) {
        AddPair(iteration, result, first, second);
      }
    }
  }
  const ScoreRows rows = rows_;
  lock.unlock();  // nobody waits for the disk
  file_.Write(rows);
}

Contestant League::ContestantOf(const Finish& finish) const {
  const bool of_run = finish.weights_version > 0 && finish.weights_version < kFirstFileVersion;
  if (of_run) return {.player = "", .version = finish.weights_version};
  return {.player = players_.at(finish.player), .version = 0};
}

void League::AddPair(int iteration, const GameResult& result, AgentId first, AgentId second) {
  const auto& finishes = result.finishes;
  const bool seated = finishes[first].lasted > 0 && finishes[second].lasted > 0;
  if (!seated || finishes[first].mate == second) return;
  const Contestant a = ContestantOf(finishes[first]);
  const Contestant b = ContestantOf(finishes[second]);
  if (a == b) return;
  const int outcome = Compare(PlaceOf(result, first), PlaceOf(result, second));
  if (outcome == 0 && !result.outcome.done) return;  // both lived on
  MatchScore score;
  score.Add(a < b ? outcome : -outcome);
  const Pair pair = std::minmax(a, b);
  rows_[{iteration, pair.first.name(), pair.second.name()}] += score;
  totals_[pair] += score;
}

std::uint32_t League::DrawPast(std::uint32_t oldest, std::uint32_t newest, Rng& rng) const {
  const std::lock_guard lock(mutex_);
  std::map<std::uint32_t, MatchScore> ours;  // against each, whatever our version was
  for (std::uint32_t back = 1; oldest + back <= newest; back *= 2) ours[newest - back];
  if (ours.empty()) return 0;
  for (const auto& [pair, score] : totals_) {
    if (pair.first.version == 0 || pair.second.version == 0) continue;  // a script
    if (const auto met = ours.find(pair.first.version); met != ours.end()) {
      met->second += Mirrored(score);  // the second is the newer one
    }
  }
  std::vector<double> weights;
  for (const auto& [version, score] : ours) {
    const auto games = static_cast<double>(score.games());
    const double p =
        (static_cast<double>(score.wins) + 0.5 * static_cast<double>(score.ties) + 1) / (games + 2);
    weights.push_back((1 - p) * (1 - p));
  }
  double left = rng.Uniform() * std::accumulate(weights.begin(), weights.end(), 0.0);
  auto version = ours.begin();
  for (std::size_t i = 0; i + 1 < weights.size() && (left -= weights[i]) >= 0; ++i) ++version;
  return version->first;
}

std::vector<RatedName> League::Ratings() const {
  NamedScores scores;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [pair, score] : totals_)
      scores[{pair.first.name(), pair.second.name()}] = score;
  }
  return RateNames(scores);
}

std::string League::RatingsCsv() const {
  std::string text = "name,games,elo,elo_low95,elo_high95\n";
  for (const auto& [name, games, rating] : Ratings()) {
    text += StrCat(name, ",", games, ",", rating.elo, ",", rating.elo - rating.half_interval, ",",
                   rating.elo + rating.half_interval, "\n");
  }
  return text;
}

std::optional<Rating> League::Progress() const {
  const std::vector<RatedName> rated = Ratings();
  const auto version = [](const RatedName& r) { return Named(r.name).version; };
  auto versions = rated | std::views::filter(version);
  if (std::ranges::distance(versions) < 2) return std::nullopt;
  const auto [oldest, newest] = std::ranges::minmax_element(versions, {}, version);
  return Rating{
      .elo = newest->rating.elo - oldest->rating.elo,
      .half_interval = std::hypot(newest->rating.half_interval, oldest->rating.half_interval)};
}

}  // namespace powderkeg

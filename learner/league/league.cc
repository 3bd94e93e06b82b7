#include "learner/league/league.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <functional>
#include <numeric>
#include <optional>
#include <sstream>
#include <utility>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/durable_file.h"
#include "common/record/game_setup.h"

namespace powderkeg {
namespace {

constexpr std::string_view kHeader = "iteration,first,second,wins,ties,losses";

MatchScore Mirrored(const MatchScore& score) {
  return {.wins = score.losses, .ties = score.ties, .losses = score.wins};
}

MatchScore ScoreOf(int outcome) {
  return {
      .wins = outcome > 0 ? 1u : 0, .ties = outcome == 0 ? 1u : 0, .losses = outcome < 0 ? 1u : 0};
}

// Of the first: +1, 0, -1; nullopt where it is not known.
std::optional<int> Compare(const GameResult& result, AgentId first, AgentId second) {
  const auto& [finishes, outcome] = result;
  if (finishes[first].mate >= 0) {  // teams
    if (outcome.result != Result::kWin) return 0;
    return (outcome.winners >> first & 1) != 0 ? 1 : -1;
  }
  if (outcome.result == Result::kWin) {
    if ((outcome.winners >> first & 1) != 0) return 1;
    if ((outcome.winners >> second & 1) != 0) return -1;
  }
  const int lead = int{finishes[first].lasted} - int{finishes[second].lasted};
  if (lead == 0 && !outcome.done) return std::nullopt;
  return lead > 0 ? 1 : lead < 0 ? -1 : 0;
}

template <typename Number>
std::optional<Number> Parse(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

// What Contestant::name() wrote.
Contestant Named(const std::string& name) {
  if (const auto version =
          name.starts_with("v") ? Parse<std::uint32_t>(name.substr(1)) : std::nullopt) {
    return {.player = "", .version = *version};
  }
  return {.player = name, .version = 0};
}

}  // namespace

std::string Contestant::name() const { return version == 0 ? player : StrCat("v", version); }

League::League(std::filesystem::path file, std::vector<std::string> players, int iterations_done)
    : file_(std::move(file)), players_(std::move(players)) {
  if (std::filesystem::exists(file_)) Read(iterations_done);
}

void League::Add(int iteration, std::span<const GameResult> results) {
  const std::lock_guard lock(mutex_);
  for (const GameResult& result : results) {
    for (AgentId first = 0; first < kAgentCount; ++first) {
      for (AgentId second = first + 1; second < kAgentCount; ++second) {
        AddPair(iteration, result, first, second);
      }
    }
  }
  Write();
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
  const std::optional<int> outcome = Compare(result, first, second);
  if (a == b || !outcome) return;
  AddScore(iteration, a < b ? Pair(a, b) : Pair(b, a), ScoreOf(a < b ? *outcome : -*outcome));
}

void League::AddScore(int iteration, const Pair& pair, const MatchScore& score) {
  by_iteration_[{iteration, pair.first, pair.second}] += score;
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

std::vector<RatedContestant> League::Ratings() const {
  const std::lock_guard lock(mutex_);
  std::map<Contestant, std::size_t> index;
  for (const auto& [pair, score] : totals_) {
    index.emplace(pair.first, index.size());
    index.emplace(pair.second, index.size());
  }
  std::vector<RatedContestant> rated(index.size());
  for (const auto& [contestant, place] : index) rated[place].contestant = contestant;
  std::vector<PairScore> pairs;
  for (const auto& [pair, score] : totals_) {
    pairs.push_back({index[pair.first], index[pair.second], score});
    rated[pairs.back().first].games += score.games();
    rated[pairs.back().second].games += score.games();
  }
  const std::vector<Rating> ratings = RatePlayers(index.size(), pairs);
  for (std::size_t i = 0; i < rated.size(); ++i) rated[i].rating = ratings[i];
  std::ranges::sort(rated, std::greater(), [](const auto& r) { return r.rating.elo; });
  return rated;
}

void League::Read(int iterations_done) {
  std::ifstream in(file_);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (number == 1 && line == kHeader) continue;
    std::istringstream row(line);
    std::array<std::string, 6> fields;
    for (std::string& field : fields) std::getline(row, field, ',');
    const auto iteration = Parse<int>(fields[0]);
    const auto wins = Parse<std::uint64_t>(fields[3]);
    const auto ties = Parse<std::uint64_t>(fields[4]);
    const auto losses = Parse<std::uint64_t>(fields[5]);
    if (!iteration || !wins || !ties || !losses) {
      throw Error(StrCat(file_.string(), ":", number, ": \"", line, "\"; expected ", kHeader));
    }
    if (*iteration > iterations_done) continue;
    AddScore(*iteration, {Named(fields[1]), Named(fields[2])}, {*wins, *ties, *losses});
  }
}

void League::Write() const {
  std::ostringstream out;
  out << kHeader << '\n';
  for (const auto& [key, score] : by_iteration_) {
    const auto& [iteration, first, second] = key;
    out << iteration << ',' << first.name() << ',' << second.name() << ',' << score.wins << ','
        << score.ties << ',' << score.losses << '\n';
  }
  const std::string text = out.str();
  WriteFileDurably(file_, BytesOf(text));
}

}  // namespace powderkeg

#include "actors/arena/contest.h"

#include <algorithm>

#include "common/base/check.h"

namespace powderkeg {
namespace {

// Lets the player play on while the watcher looks on.
void Play(MatchPlayer& player, int agent, int games, ContestWatcher& watcher,
          const std::function<bool(const PlayedGame&)>& is_enough) {
  watcher.Began(agent);
  player.Play(games, {.on_game = [&](const PlayedGame& game) { watcher.Played(agent, game); },
                      .is_enough = is_enough});
  watcher.Paused(agent);
}

// The next game of the test has this result; whether that answers the question.
bool Add(double sample, int agent, SequentialTest& test, ContestWatcher& watcher) {
  test.Add(sample);
  watcher.Tested(agent, test.state());
  return test.state().answer != Answer::kOpen;
}

ContestResult PlayAlone(const MatchLineup& lineup, int agent, const ContestSettings& settings,
                        const ModelLoader& loader, ContestWatcher& watcher) {
  MatchPlayer player(lineup, settings.match, loader);
  if (!settings.question) {
    Play(player, agent, settings.match.games, watcher, nullptr);
    return {player.match(), std::nullopt};
  }
  SequentialTest test(*settings.question, settings.min_games);
  Play(player, agent, settings.match.games, watcher, [&](const PlayedGame& game) {
    return Add(game.outcomes[0] > 0 ? 1 : 0, agent, test, watcher);
  });
  return {player.match(), test.state()};
}

// Enough games that the threads are seldom without work, few compared with those already played.
int NextTurn(const ContestSettings& settings, std::size_t played) {
  const int games = static_cast<int>(played);
  constexpr int kGamesPerThread = 16;
  return std::min(
      settings.match.games - games,
      std::max({settings.min_games, games / 4, kGamesPerThread * settings.match.threads}));
}

std::vector<ContestResult> PlayInTurns(std::span<const MatchLineup> lineups,
                                       const ContestSettings& settings, const ModelLoader& loader,
                                       ContestWatcher& watcher) {
  MatchPlayer base(lineups[0], settings.match, loader);
  MatchPlayer other(lineups[1], settings.match, loader);
  SequentialTest test(*settings.question, settings.min_games);
  const auto is_enough = [&](const PlayedGame& game) {
    const int base_outcome = base.match().games[static_cast<std::size_t>(game.number)].outcomes[0];
    return Add(0.5 * (game.outcomes[0] - base_outcome), /*agent=*/1, test, watcher);
  };
  while (test.state().answer == Answer::kOpen) {
    const int games = NextTurn(settings, base.match().games.size());
    if (games == 0) break;
    Play(base, /*agent=*/0, games, watcher, nullptr);
    Play(other, /*agent=*/1, games, watcher, is_enough);
  }
  base.KeepFirst(other.match().games.size());
  return {{base.match(), std::nullopt}, {other.match(), test.state()}};
}

}  // namespace

std::vector<ContestResult> PlayContest(std::span<const MatchLineup> lineups,
                                       const ContestSettings& settings, const ModelLoader& loader,
                                       ContestWatcher& watcher) {
  if (settings.question && settings.question->figure == Question::Figure::kScoreDifference) {
    if (lineups.size() != 2) {
      throw Error(StrCat("question \"", settings.question->text, "\": ", lineups.size(),
                         " agents to measure, expected 2"));
    }
    return PlayInTurns(lineups, settings, loader, watcher);
  }
  std::vector<ContestResult> results;
  for (std::size_t agent = 0; agent < lineups.size(); ++agent) {
    results.push_back(
        PlayAlone(lineups[agent], static_cast<int>(agent), settings, loader, watcher));
  }
  return results;
}

}  // namespace powderkeg

#include "actors/arena/match.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "actors/play/agent_pool.h"
#include "common/base/check.h"
#include "common/base/worker.h"
#include "common/config/tree_memory.h"
#include "common/pommerman/board_text.h"

namespace powderkeg {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

AgentId SeatOf(int role, int number, int seats) { return (role + number) % seats; }

// A server of the official protocol plays one game at a time.
bool OneByOne(const MatchLineup& lineup) {
  return std::ranges::find(lineup, AgentSpec::Kind::kForeign, &AgentSpec::kind) != lineup.end();
}

// Without a network, games side by side only crowd the caches.
int GamesInFlight(const MatchSettings& settings, const MatchLineup& lineup) {
  if (OneByOne(lineup)) return 1;
  if (settings.games_in_flight > 0) return settings.games_in_flight;
  constexpr int kWithModel = 16;
  const bool plain = std::ranges::all_of(lineup, &std::string::empty, &AgentSpec::model_file);
  return plain ? 1 : kWithModel;
}

std::vector<int> MeasuredRoles(const MatchLineup& lineup, Mode mode) {
  if (IsTeamMode(mode) && lineup[2].text == lineup[0].text) return {0, 2};
  return {0};
}

// What the threads of a go share.
class Scoreboard {
 public:
  // For `games` more games of the match.
  Scoreboard(Match& match, int games, const MatchObserver& observer)
      : next_number_(static_cast<int>(match.games.size())),
        end_(next_number_ + games),
        match_(match),
        observer_(observer) {}

  // The number of a game nobody has played yet; nullopt when all are given out. Thread-safe.
  std::optional<int> TakeNumber() {
    const int number = next_number_.fetch_add(1);
    if (number >= end_) return std::nullopt;
    return number;
  }

  // Thread-safe.
  void AddGame(const PlayedGame& game) {
    const std::lock_guard lock(mutex_);
    if (stopped()) return;
    observer_.on_game(game);
    early_.emplace(game.number, game);
    while (!stopped() && !early_.empty() && IsNext(early_.begin()->first)) {
      match_.games.push_back(early_.begin()->second);
      early_.erase(early_.begin());
      if (observer_.is_enough && observer_.is_enough(match_.games.back())) stopped_ = true;
    }
  }

  // Thread-safe.
  void AddThread(const LoopMetrics& metrics, double seconds, std::uint64_t moves) {
    const std::lock_guard lock(mutex_);
    match_.metrics += metrics;
    match_.thread_seconds += seconds;
    match_.timed_moves += moves;
  }

  // Ends the match for all threads; whether this call did it. Thread-safe.
  bool Stop() { return !stopped_.exchange(true); }
  [[nodiscard]] bool stopped() const { return stopped_; }

 private:
  [[nodiscard]] bool IsNext(int number) const {
    return number == static_cast<int>(match_.games.size());
  }

  std::atomic<int> next_number_;
  std::atomic<bool> stopped_ = false;
  const int end_;
  std::mutex mutex_;
  Match& match_;                     // guarded by mutex_
  const MatchObserver& observer_;    // called under mutex_
  std::map<int, PlayedGame> early_;  // ended before a game of a lower number; guarded by mutex_
};

// The environment's word, which ties whoever died before a tie.
std::int8_t OfficialOutcome(const Outcome& outcome, AgentId seat) {
  if (outcome.result == Result::kTie) return 0;
  return outcome.Won(seat) ? 1 : -1;
}

// Writes the position; "the position is saved in FILE", or why it is not.
std::string SavePosition(const State& state, const std::string& path) {
  std::ofstream file(path);
  file << ToText(state) << std::flush;
  return file ? StrCat("the position is saved in ", path)
              : StrCat("the position could not be saved in ", path);
}

}  // namespace

// The games of one thread.
class MatchThread final : public GameHost {
 public:
  MatchThread(const MatchLineup& lineup, const MatchSettings& settings,
              const std::vector<int>& roles, const ModelLoader& loader)
      : lineup_(lineup),
        settings_(settings),
        roles_(roles),
        agents_({lineup.begin(), lineup.end()}) {
    for (const AgentSpec& description : lineup) {
      if (!models_.contains(description.model_file)) {
        models_[description.model_file] = MakeModel(description.model_file, loader);
      }
    }
  }

  // Plays until the scoreboard has no more games. An error ends the match for all threads.
  void Run(Scoreboard& scoreboard, const std::stop_token& stop) {
    scoreboard_ = &scoreboard;
    try {
      PlayGames(stop);
    } catch (const BadEvaluation& error) {
      if (!scoreboard.Stop()) return;  // another thread says what happened
      throw Error(StrCat("agent ", AgentOf(error.evaluator()), ": ", error.what(), "; ",
                         SavePosition(error.state(), settings_.position_file)));
    } catch (const Error&) {
      scoreboard.Stop();
      throw;
    }
  }

  std::optional<GamePlan> NextGame(int slot) override {
    const std::optional<int> number = scoreboard_->TakeNumber();
    if (!number) return std::nullopt;
    GamePlan plan;
    plan.ticket = static_cast<std::uint64_t>(*number);
    plan.setup = SetupOf(settings_, lineup_, *number);
    const int seats = SeatCount(settings_.game.mode);
    for (int role = 0; role < seats; ++role) {
      const AgentId seat = SeatOf(role, *number, seats);
      if (!plan.setup.seats[seat].searches) continue;
      // One agent for each role, whatever its seat.
      plan.agents[seat] = {agents_.At(slot, /*seat=*/role, static_cast<std::size_t>(role)),
                           models_.at(lineup_[role].model_file)};
    }
    return plan;
  }

  void GameFinished(int /*slot*/, Game& game) override {
    const GameRecord& record = game.record();
    const int seats = SeatCount(settings_.game.mode);
    PlayedGame played;
    played.number = static_cast<int>(record.ticket);
    played.seed = record.setup.seed;
    played.steps = static_cast<int>(record.actions.size());
    played.seat = SeatOf(/*role=*/0, played.number, seats);
    for (int role = 0; role < seats; ++role) {
      const AgentId seat = SeatOf(role, played.number, seats);
      played.outcomes[role] = OfficialOutcome(record.outcome, seat);
      played.died[role] = !game.state().agents[seat].alive;
      played.statistics[role] = game.statistics(seat);
    }
    moves_ += MeasuredMoves(game);
    scoreboard_->AddGame(played);
  }

 private:
  void PlayGames(const std::stop_token& stop) {
    const Clock::time_point start = Clock::now();
    moves_ = 0;
    GameLoop loop(*this, settings_.game, settings_.games_in_flight);
    while (!stop.stop_requested() && !scoreboard_->stopped() && loop.RunRound()) {
    }
    for (int slot = 0; slot < settings_.games_in_flight; ++slot) {
      if (const Game* game = loop.running_game(slot)) moves_ += MeasuredMoves(*game);
    }
    scoreboard_->AddThread(loop.metrics(), SecondsSince(start), moves_);
  }

  [[nodiscard]] std::uint64_t MeasuredMoves(const Game& game) const {
    const int number = static_cast<int>(game.plan().ticket);
    std::uint64_t moves = 0;
    for (const int role : roles_) {
      moves += game.statistics(SeatOf(role, number, SeatCount(settings_.game.mode))).moves;
    }
    return moves;
  }

  // The first agent, by role, that the evaluator answers.
  [[nodiscard]] std::string AgentOf(const Evaluator* evaluator) const {
    const auto agent = std::ranges::find_if(lineup_, [&](const AgentSpec& description) {
      return models_.at(description.model_file).evaluator.get() == evaluator;
    });
    return agent == lineup_.end() ? "unknown" : agent->text;
  }

  const MatchLineup& lineup_;
  const MatchSettings& settings_;
  const std::vector<int>& roles_;
  Scoreboard* scoreboard_ = nullptr;     // of this go
  std::uint64_t moves_ = 0;              // of the measured agent in this go
  std::map<std::string, Model> models_;  // by file
  AgentPool agents_;
};

GameSetup SetupOf(const MatchSettings& settings, const MatchLineup& lineup, int number) {
  GameSetup setup;
  setup.settings = settings.game;
  setup.start = settings.start;
  setup.seed = Rng(settings.seed).Split(static_cast<std::uint64_t>(number)).Next();
  const int seats = SeatCount(settings.game.mode);
  for (int role = 0; role < seats; ++role) {
    const AgentSpec& description = lineup[role];
    setup.seats[SeatOf(role, number, seats)] = {
        .searches = description.kind != AgentSpec::Kind::kRuleBased,
        .policy = description.policy,
        .player = static_cast<std::uint8_t>(role)};
  }
  return setup;
}

std::size_t TreeBytes(const MatchLineup& lineup, const MatchSettings& settings) {
  const int seats = SeatCount(settings.game.mode);
  const int trees =
      std::min(settings.games, settings.threads * GamesInFlight(settings, lineup) * seats);
  std::size_t bytes = 0;
  for (int role = 0; role < seats; ++role) {
    bytes += static_cast<std::size_t>(trees) * TreeBytes(lineup[role]);
  }
  return bytes;
}

MatchPlayer::MatchPlayer(const MatchLineup& lineup, const MatchSettings& settings,
                         const ModelLoader& loader)
    : lineup_(lineup), settings_(settings) {
  CHECK(settings.threads > 0 && settings.games > 0, settings.threads, " ", settings.games);
  settings_.games_in_flight = GamesInFlight(settings, lineup);
  if (OneByOne(lineup)) settings_.threads = 1;
  match_.roles = MeasuredRoles(lineup, settings.game.mode);
  for (int i = 0; i < settings_.threads; ++i) {
    threads_.push_back(std::make_unique<MatchThread>(lineup_, settings_, match_.roles, loader));
  }
}

MatchPlayer::~MatchPlayer() = default;

void MatchPlayer::Play(int games, const MatchObserver& observer) {
  const Clock::time_point start = Clock::now();
  Scoreboard scoreboard(match_, games, observer);
  std::vector<std::unique_ptr<Worker>> workers;
  for (std::size_t i = 0; i < threads_.size(); ++i) {
    workers.push_back(std::make_unique<Worker>(
        StrCat("arena ", i), [&scoreboard, &thread = *threads_[i]](const std::stop_token& stop) {
          thread.Run(scoreboard, stop);
        }));
  }
  for (const std::unique_ptr<Worker>& worker : workers) worker->Join();
  match_.seconds += SecondsSince(start);
}

void MatchPlayer::KeepFirst(std::size_t games) {
  CHECK(games <= match_.games.size(), games, " of ", match_.games.size());
  match_.games.resize(games);
}

}  // namespace powderkeg

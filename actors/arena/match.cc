#include "actors/arena/match.h"

#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "common/base/check.h"
#include "common/base/worker.h"

namespace powderkeg {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

int SeatCount(const GameSettings& settings) {
  return settings.mode == Mode::kOneVsOne ? 2 : kAgentCount;
}

AgentId SeatOf(int role, int number, int seats) { return (role + number) % seats; }

// What the threads of a match share.
class Scoreboard {
 public:
  Scoreboard(int games, const std::function<void(const PlayedGame&)>& on_game) : on_game_(on_game) {
    match_.games.resize(static_cast<std::size_t>(games));
  }

  // The number of a game nobody has played yet; nullopt when all are given out. Thread-safe.
  std::optional<int> TakeNumber() {
    const int number = next_number_.fetch_add(1);
    if (number >= static_cast<int>(match_.games.size())) return std::nullopt;
    return number;
  }

  // Thread-safe.
  void AddGame(const PlayedGame& game) {
    const std::lock_guard lock(mutex_);
    match_.games[static_cast<std::size_t>(game.number)] = game;
    on_game_(game);
  }

  // Thread-safe.
  void AddThread(const LoopMetrics& metrics, double seconds) {
    const std::lock_guard lock(mutex_);
    match_.metrics += metrics;
    match_.thread_seconds += seconds;
  }

  // When the threads have ended.
  [[nodiscard]] Match TakeMatch() { return std::move(match_); }

 private:
  std::atomic<int> next_number_ = 0;
  std::mutex mutex_;
  const std::function<void(const PlayedGame&)>& on_game_;  // called under mutex_
  Match match_;                                            // guarded by mutex_
};

// The games of one thread.
class MatchThread final : public GameHost {
 public:
  MatchThread(const Lineup& lineup, const MatchSettings& settings, const ModelLoader& loader,
              Scoreboard& scoreboard)
      : lineup_(lineup),
        settings_(settings),
        scoreboard_(scoreboard),
        slots_(static_cast<std::size_t>(settings.games_in_flight)) {
    for (const AgentDescription& description : lineup) {
      if (!models_.contains(description.model_file)) {
        models_[description.model_file] = MakeModel(description.model_file, loader);
      }
    }
  }

  void Run(const std::stop_token& stop) {
    const Clock::time_point start = Clock::now();
    GameLoop loop(*this, settings_.game, settings_.games_in_flight);
    while (!stop.stop_requested() && loop.RunRound()) {
    }
    scoreboard_.AddThread(loop.metrics(), SecondsSince(start));
  }

  std::optional<GamePlan> NextGame(int slot) override {
    const std::optional<int> number = scoreboard_.TakeNumber();
    if (!number) return std::nullopt;
    GamePlan plan;
    plan.ticket = static_cast<std::uint64_t>(*number);
    plan.setup = SetupOf(settings_, lineup_, *number);
    const int seats = SeatCount(settings_.game);
    for (int role = 0; role < seats; ++role) {
      const AgentId seat = SeatOf(role, *number, seats);
      if (plan.setup.seats[seat].searches) plan.players[seat] = PlayerOf(slot, role);
    }
    return plan;
  }

  void GameFinished(int /*slot*/, Game& game) override {
    const GameRecord& record = game.record();
    const int seats = SeatCount(settings_.game);
    PlayedGame played;
    played.number = static_cast<int>(record.ticket);
    played.seed = record.setup.seed;
    played.steps = static_cast<int>(record.actions.size());
    played.seat = SeatOf(/*role=*/0, played.number, seats);
    for (int role = 0; role < seats; ++role) {
      const AgentId seat = SeatOf(role, played.number, seats);
      played.outcomes[role] = static_cast<std::int8_t>(OutcomeFor(record, seat));
      played.statistics[role] = game.statistics(seat);
    }
    scoreboard_.AddGame(played);
  }

 private:
  using Agents = std::array<std::unique_ptr<Agent>, kAgentCount>;  // by role

  Player PlayerOf(int slot, int role) {
    std::unique_ptr<Agent>& agent = slots_[static_cast<std::size_t>(slot)][role];
    if (agent == nullptr) agent = MakeAgent(lineup_[role]);
    return {agent.get(), models_.at(lineup_[role].model_file)};
  }

  const Lineup& lineup_;
  const MatchSettings& settings_;
  Scoreboard& scoreboard_;
  std::map<std::string, Model> models_;  // by file
  std::vector<Agents> slots_;            // made when first needed, then reused
};

}  // namespace

GameSetup SetupOf(const MatchSettings& settings, const Lineup& lineup, int number) {
  GameSetup setup;
  setup.settings = settings.game;
  setup.start = settings.start;
  setup.seed = Rng(settings.seed).Split(static_cast<std::uint64_t>(number)).Next();
  const int seats = SeatCount(settings.game);
  for (int role = 0; role < seats; ++role) {
    const AgentDescription& description = lineup[role];
    setup.seats[SeatOf(role, number, seats)] = {
        .searches = description.kind != AgentDescription::Kind::kRuleBased,
        .policy = description.policy};
  }
  return setup;
}

Match PlayMatch(const Lineup& lineup, const MatchSettings& settings, const ModelLoader& loader,
                const std::function<void(const PlayedGame&)>& on_game) {
  CHECK(settings.threads > 0 && settings.games > 0, settings.threads, " ", settings.games);
  const Clock::time_point start = Clock::now();
  Scoreboard scoreboard(settings.games, on_game);
  std::vector<std::unique_ptr<MatchThread>> threads;
  for (int i = 0; i < settings.threads; ++i) {
    threads.push_back(std::make_unique<MatchThread>(lineup, settings, loader, scoreboard));
  }
  std::vector<std::unique_ptr<Worker>> workers;
  for (int i = 0; i < settings.threads; ++i) {
    workers.push_back(std::make_unique<Worker>(
        StrCat("arena ", i), [&thread = *threads[i]](const auto& stop) { thread.Run(stop); }));
  }
  for (const std::unique_ptr<Worker>& worker : workers) worker->Join();
  Match match = scoreboard.TakeMatch();
  match.seconds = SecondsSince(start);
  return match;
}

}  // namespace powderkeg

// official_match: agents behind HTTP against rule-based ones, under a client that behaves as the
// official runner; how they did and how long they took.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "actors/runner/official_client.h"
#include "common/base/check.h"
#include "common/base/run_main.h"
#include "common/base/stats.h"
#include "common/pommerman/observation.h"
#include "common/record/rule_based_seat.h"

namespace powderkeg {
namespace {

constexpr double kPublishedLimitMs = 100;

struct Arguments {
  std::vector<std::string> servers = {"127.0.0.1:10080"};
  int games = 100;
  int minutes = 0;  // 0: no limit
  std::string environment = "PommeFFACompetition-v0";
  std::vector<std::string> opponents = {"official_simple"};
  std::uint64_t seed = 1;
};

void AddOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("--server", arguments.servers,
                 "one or more, HOST:PORT; each plays one game at a time");
  app.add_option("--games", arguments.games)->check(CLI::Range(1, 1'000'000));
  app.add_option("--minutes", arguments.minutes, "after which no game begins; 0: no limit")
      ->check(CLI::Range(0, 100'000));
  app.add_option("--environment", arguments.environment, KnownEnvironmentIds());
  app.add_option("--opponents", arguments.opponents,
                 "policies of the seats that follow the agent's; the last one fills the rest")
      ->expected(1, kAgentCount - 1);
  app.add_option("--seed", arguments.seed, "of boards and opponents");
}

// What there is to play. Immutable.
struct Plan {
  GameSettings settings;
  std::array<PolicyKind, kAgentCount - 1> opponents{};
  std::uint64_t seed = 1;

  // The seat of the agent behind HTTP.
  [[nodiscard]] AgentId SeatOf(int game) const {
    return game % (settings.mode == Mode::kOneVsOne ? 2 : kAgentCount);
  }
  [[nodiscard]] GameSetup SetupOf(int game) const {
    GameSetup setup;
    setup.settings = settings;
    setup.seed = Rng(seed).Split(static_cast<std::uint64_t>(game)).Next();
    const AgentId own = SeatOf(game);
    setup.seats[own].searches = true;
    for (AgentId i = 1; i < kAgentCount; ++i) {
      setup.seats[(own + i) % kAgentCount].policy = opponents[i - 1];
    }
    return setup;
  }
};

PolicyKind PolicyOf(const std::string& name) {
  const auto kind = PolicyKindFor(name);
  if (!kind) throw Error(StrCat("--opponents ", name, ": expected a policy by name"));
  return *kind;
}

Plan PlanOf(const Arguments& arguments) {
  const auto settings = GameSettingsFor(arguments.environment);
  if (!settings) {
    throw Error(StrCat("--environment ", arguments.environment, ": expected one of ",
                       KnownEnvironmentIds()));
  }
  Plan plan{.settings = *settings, .opponents = {}, .seed = arguments.seed};
  for (std::size_t i = 0; i < plan.opponents.size(); ++i) {
    plan.opponents[i] = PolicyOf(arguments.opponents[std::min(i, arguments.opponents.size() - 1)]);
  }
  return plan;
}

// What is measured, over games.
struct Measurement {
  MatchScore score;
  std::uint64_t steps = 0;
  std::vector<double> milliseconds;  // of every answer to /action
  std::uint64_t late = 0;            // answers that did not come in time

  void operator+=(const Measurement& other) {
    score += other.score;
    steps += other.steps;
    milliseconds.insert(milliseconds.end(), other.milliseconds.begin(), other.milliseconds.end());
    late += other.late;
  }
};

// One game in the official order: observations, then a collapse, then the step.
class Match {
 public:
  Match(const Plan& plan, const HttpAddress& server) : plan_(plan), client_({.server = server}) {}

  [[nodiscard]] Measurement Play(int game) {
    measurement_ = {};
    const AgentId own = plan_.SeatOf(game);
    const GameSetup setup = plan_.SetupOf(game);
    client_.Ping();
    client_.Initialise(own, plan_.settings.mode);
    const Outcome outcome = PlaySteps(setup, own);
    client_.EndEpisode(outcome.rewards[own]);
    client_.Shutdown();
    const bool won = (outcome.winners >> own & 1) != 0;
    ++(outcome.result == Result::kTie ? measurement_.score.ties
       : won                          ? measurement_.score.wins
                                      : measurement_.score.losses);
    return measurement_;
  }

 private:
  [[nodiscard]] Outcome PlaySteps(const GameSetup& setup, AgentId own) {
    const GameSettings& settings = setup.settings;
    State state = GenerateStart(settings, setup.start, BoardRng(setup));
    std::array<RuleBasedSeat, kAgentCount> seats;
    for (AgentId id = 0; id < kAgentCount; ++id) {
      if (id != own) seats[id] = RuleBasedSeat(setup, id);
    }
    for (;;) {
      JointAction actions{};
      std::array<Message, kAgentCount> words{};
      for (AgentId id = 0; id < kAgentCount; ++id) {
        if (!state.agents[id].alive) continue;
        actions[id] = id == own ? Ask(Observe(settings, state, own), words[own])
                                : seats[id].Decide(settings, state);
      }
      Collapse(settings, state);
      Step(settings, actions, words, state);
      ++measurement_.steps;
      if (const Outcome outcome = OutcomeOf(settings, state); outcome.done) return outcome;
    }
  }

  // As the runner does, stops where the agent does not answer in time.
  Action Ask(const Observation& observation, Message& words) {
    const auto start = std::chrono::steady_clock::now();
    const RunnerMove move = client_.Act(plan_.settings, observation);
    const std::chrono::duration<double, std::milli> duration =
        std::chrono::steady_clock::now() - start;
    measurement_.milliseconds.push_back(duration.count());
    measurement_.late += move.late ? 1 : 0;
    words = move.words;
    return move.action;
  }

  const Plan& plan_;
  OfficialClient client_;
  Measurement measurement_;
};

// Deals the games to the servers; each plays in a thread of its own.
Measurement PlayAll(const Plan& plan, const Arguments& arguments) {
  using Clock = std::chrono::steady_clock;
  const auto end = arguments.minutes == 0 ? Clock::time_point::max()
                                          : Clock::now() + std::chrono::minutes(arguments.minutes);
  std::mutex mutex;  // guards `sum` and `failure`
  Measurement sum;
  std::string failure;
  std::atomic<int> next_game = 0;
  const auto play = [&](const std::string& text) {
    try {
      const std::optional<HttpAddress> server = ParseHttpAddress(text);
      if (!server) throw Error("expected HOST:PORT");
      Match match(plan, *server);
      for (int game = 0; (game = next_game++) < arguments.games && Clock::now() < end;) {
        const Measurement played = match.Play(game);
        const std::lock_guard lock(mutex);
        sum += played;
      }
    } catch (const Error& error) {
      const std::lock_guard lock(mutex);
      failure = StrCat("--server ", text, ": ", error.what());
    }
  };
  std::vector<std::jthread> servers;
  for (const std::string& text : arguments.servers) servers.emplace_back(play, text);
  servers.clear();
  if (!failure.empty()) throw Error(failure);
  return sum;
}

void PrintRate(const char* name, std::uint64_t count, std::uint64_t games) {
  const Interval interval = WilsonInterval(count, games);
  std::printf("%-6s %.3f  [%.3f, %.3f]\n", name,
              static_cast<double>(count) / static_cast<double>(games), interval.low, interval.high);
}

void Print(Measurement measurement) {
  const std::uint64_t games = measurement.score.games();
  std::vector<double>& times = measurement.milliseconds;
  if (times.empty()) throw Error("no game was played");
  std::ranges::sort(times);
  const auto quantile = [&](double share) {
    return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
  };
  const auto slow = times.end() - std::ranges::upper_bound(times, kPublishedLimitMs);
  std::printf("%llu games of %.0f steps on average\n", static_cast<unsigned long long>(games),
              static_cast<double>(measurement.steps) / static_cast<double>(games));
  PrintRate("win", measurement.score.wins, games);
  PrintRate("tie", measurement.score.ties, games);
  PrintRate("loss", measurement.score.losses, games);
  std::printf(
      "%zu actions asked for; ms to the answer: p50 %.1f, p99 %.1f, p99.9 %.1f, most %.1f\n",
      times.size(), quantile(0.5), quantile(0.99), quantile(0.999), times.back());
  std::printf("over %.0f ms: %td (%.3f %%), no action in time: %llu\n", kPublishedLimitMs, slow,
              100 * static_cast<double>(slow) / static_cast<double>(times.size()),
              static_cast<unsigned long long>(measurement.late));
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  CLI::App app("Plays an agent behind HTTP as the official runner does.", "official_match");
  powderkeg::Arguments arguments;
  powderkeg::AddOptions(app, arguments);
  return powderkeg::RunMain(app, argc, argv, [&] {
    powderkeg::Print(powderkeg::PlayAll(powderkeg::PlanOf(arguments), arguments));
    return powderkeg::kDone;
  });
}

// oracle_match [GAMES [SIMULATIONS...]]: what knowing the opponents is worth.
//
// The search of the paper preset, without a network, plays against three SimpleUnbiased on the same
// boards with models that remember nothing (reset), what was seen (synchronized), what explains
// what was seen (inferred), and with the opponents' hidden orders known beside what was seen
// (oracle). For each it prints wins and ties, the share of the opponents' actions foretold at the
// root, and how much of the way from synchronized to oracle the wins went. Uses all cores; equal
// arguments give equal figures.

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <thread>
#include <vector>

#include "actors/search/search.h"
#include "common/base/stats.h"
#include "common/pommerman/belief.h"
#include "common/record/game_record.h"
#include "common/record/rule_based_seat.h"
#include "tests/search/search_support.h"

namespace powderkeg {
namespace {

struct Knowledge {
  const char* name;
  ModelMemory memory;
  bool orders_known;
};
constexpr std::array<Knowledge, 4> kKnowledge = {
    Knowledge{"reset", ModelMemory::kReset, false},
    Knowledge{"synchronized", ModelMemory::kSynchronized, false},
    Knowledge{"inferred", ModelMemory::kInferred, false},
    Knowledge{"oracle", ModelMemory::kSynchronized, true}};

struct Score {
  std::uint64_t games = 0;
  std::uint64_t wins = 0;
  std::uint64_t ties = 0;
  std::uint64_t actions = 0;   // of living opponents where the agent searched
  std::uint64_t foretold = 0;  // of them

  Score& operator+=(const Score& other) {
    games += other.games;
    wins += other.wins;
    ties += other.ties;
    actions += other.actions;
    foretold += other.foretold;
    return *this;
  }
  [[nodiscard]] double win_rate() const {
    return static_cast<double>(wins) / static_cast<double>(games);
  }
};

// One game as it goes on.
class Match {
 public:
  Match(const Knowledge& knowledge, int simulations, std::uint64_t game)
      : self_(static_cast<AgentId>(game % kAgentCount)), belief_(setup_.settings, {}) {
    setup_.seed = 1 + game / kAgentCount;
    setup_.start.corners = StartCorners::kPermuted;
    setup_.seats.fill({.searches = false, .policy = PolicyKind::kSimpleUnbiased});
    setup_.seats[static_cast<std::size_t>(self_)] = {.searches = true};
    settings_ = PaperSettings();
    settings_.simulations = simulations;
    settings_.memory = knowledge.memory;
    models_.StartGame(settings_, setup_.settings, self_, SearchRng(setup_, self_).Split(0));
    for (AgentId agent = 0; agent < kAgentCount; ++agent) {
      if (agent == self_) continue;
      auto& seat = seats_[static_cast<std::size_t>(agent)];
      seat = RuleBasedSeat(setup_, agent);
      if (knowledge.orders_known) models_.KnowTraits(agent, seat.traits());
    }
  }

  Score Play() {
    Search search(settings_, setup_.settings);
    State state = GenerateStart(setup_.settings, setup_.start, BoardRng(setup_));
    Score score{.games = 1};
    for (Outcome outcome; !outcome.done;) {
      if (!state.agents[static_cast<std::size_t>(self_)].alive) return score;
      const SearchResult result = Think(search, state);
      JointAction actions{};
      for (AgentId agent = 0; agent < kAgentCount; ++agent) {
        const auto id = static_cast<std::size_t>(agent);
        if (agent == self_ || !state.agents[id].alive) continue;
        actions[id] = seats_[id].Decide(setup_.settings, state);
        if ((result.expected_agents >> agent & 1) == 0) continue;
        ++score.actions;
        if (result.expected_actions[id] == actions[id]) ++score.foretold;
      }
      actions[static_cast<std::size_t>(self_)] = result.best;
      outcome = Advance(setup_.settings, actions, state);
      if (outcome.done) score.ties = outcome.result == Result::kTie ? 1 : 0;
      if (outcome.done) score.wins = outcome.winners >> self_ & 1;
    }
    return score;
  }

 private:
  SearchResult Think(Search& search, const State& state) {
    const State before = belief_.state();
    belief_.Observe(Observe(setup_.settings, state, self_));
    if (state.step > 0) models_.ObserveStep(before, belief_.state());
    search.Start(belief_.state(), models_, SearchRng(setup_, self_).Split(1U + state.step));
    return Finish(search, evaluator_, setup_.settings);
  }

  GameSetup setup_;
  AgentId self_;
  SearchSettings settings_;
  Belief belief_;
  OpponentModels models_;
  std::array<RuleBasedSeat, kAgentCount> seats_;
  UniformEvaluator evaluator_;
};

Score PlayAll(const Knowledge& knowledge, int simulations, std::uint64_t games) {
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  std::vector<Score> scores(cores);
  std::atomic<std::uint64_t> next = 0;
  {
    std::vector<std::jthread> threads;
    for (Score& score : scores) {
      threads.emplace_back([&] {
        for (std::uint64_t game = next++; game < games; game = next++) {
          score += Match(knowledge, simulations, game).Play();
        }
      });
    }
  }
  Score all;
  for (const Score& score : scores) all += score;
  return all;
}

void Report(int simulations, std::uint64_t games) {
  std::array<double, kKnowledge.size()> win_rates{};
  for (std::size_t i = 0; i < kKnowledge.size(); ++i) {
    const Score score = PlayAll(kKnowledge[i], simulations, games);
    win_rates[i] = score.win_rate();
    const Interval interval = WilsonInterval(score.wins, score.games);
    std::printf("%11d  %-12s  %5llu  %.3f [%.3f, %.3f]  %.3f  %.3f\n", simulations,
                kKnowledge[i].name, static_cast<unsigned long long>(score.games), win_rates[i],
                interval.low, interval.high,
                static_cast<double>(score.ties) / static_cast<double>(score.games),
                static_cast<double>(score.foretold) / static_cast<double>(score.actions));
    std::fflush(stdout);
  }
  const double way = win_rates[3] - win_rates[1];
  if (way > 0) {
    std::printf("%11d  inferred went %.0f %% of the way from synchronized to oracle\n", simulations,
                100 * (win_rates[2] - win_rates[1]) / way);
  }
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  const std::vector<std::string_view> arguments(argv + 1, argv + argc);
  std::vector<int> numbers;
  for (const std::string_view argument : arguments) {
    numbers.push_back(std::atoi(argument.data()));
    if (numbers.back() < 1) {
      std::fprintf(stderr, "'%s': expected oracle_match [GAMES [SIMULATIONS...]]\n",
                   argument.data());
      return 2;
    }
  }
  const std::uint64_t games = numbers.empty() ? 400 : static_cast<std::uint64_t>(numbers[0]);
  std::printf("simulations  models        games  wins [95 %%]            ties   foretold\n");
  for (std::size_t i = 1; i < numbers.size(); ++i) powderkeg::Report(numbers[i], games);
  if (numbers.size() < 2) {
    for (const int simulations : {250, 1000}) powderkeg::Report(simulations, games);
  }
  return 0;
}

// oracle_match [GAMES [SIMULATIONS...]] [--seed SEED] [--models NAME]: what knowing the opponents
// is worth.
//
// The search of the paper preset, without a network, plays against three SimpleUnbiased on the same
// boards with models that remember nothing (reset), what was seen (synchronized), what explains
// what was seen (inferred), and with the opponents' hidden orders known beside what was seen
// (oracle). For each it prints wins and ties, the share of the opponents' actions foretold at the
// root, and how much of the way from synchronized to oracle the wins went. The boards begin with
// that of SEED (1); with NAME only models of this name play. Uses all cores; equal arguments give
// equal figures.

#include <algorithm>
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

struct Plan {
  std::uint64_t games = 400;
  std::vector<int> simulations;
  std::uint64_t first_seed = 1;
  std::string_view models;  // empty: all
};

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
  Match(const Knowledge& knowledge, int simulations, std::uint64_t first_seed, std::uint64_t game)
      : self_(static_cast<AgentId>(game % kAgentCount)), belief_(setup_.settings) {
    setup_.seed = first_seed + game / kAgentCount;
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
    if (state.step > 0) models_.ObserveStep({before}, {belief_.state()});
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

Score PlayAll(const Knowledge& knowledge, int simulations, const Plan& plan) {
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  std::vector<Score> scores(cores);
  std::atomic<std::uint64_t> next = 0;
  {
    std::vector<std::jthread> threads;
    for (Score& score : scores) {
      threads.emplace_back([&] {
        for (std::uint64_t game = next++; game < plan.games; game = next++) {
          score += Match(knowledge, simulations, plan.first_seed, game).Play();
        }
      });
    }
  }
  Score all;
  for (const Score& score : scores) all += score;
  return all;
}

void Print(int simulations, const char* name, const Score& score) {
  const Interval interval = WilsonInterval(score.wins, score.games);
  std::printf("%11d  %-12s  %5llu  %.3f [%.3f, %.3f]  %.3f  %.3f\n", simulations, name,
              static_cast<unsigned long long>(score.games), score.win_rate(), interval.low,
              interval.high, static_cast<double>(score.ties) / static_cast<double>(score.games),
              static_cast<double>(score.foretold) / static_cast<double>(score.actions));
  std::fflush(stdout);
}

void Report(int simulations, const Plan& plan) {
  std::array<double, kKnowledge.size()> win_rates{};
  for (std::size_t i = 0; i < kKnowledge.size(); ++i) {
    if (!plan.models.empty() && plan.models != kKnowledge[i].name) continue;
    const Score score = PlayAll(kKnowledge[i], simulations, plan);
    win_rates[i] = score.win_rate();
    Print(simulations, kKnowledge[i].name, score);
  }
  const double way = win_rates[3] - win_rates[1];
  if (plan.models.empty() && way > 0) {
    std::printf("%11d  inferred went %.0f %% of the way from synchronized to oracle\n", simulations,
                100 * (win_rates[2] - win_rates[1]) / way);
  }
}

// False if an argument is none.
bool Read(const std::vector<std::string_view>& arguments, Plan& plan) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const bool has_value = i + 1 < arguments.size();
    const auto is_name = [&](const Knowledge& knowledge) {
      return knowledge.name == arguments[i + 1];
    };
    if (arguments[i] == "--models") {
      if (!has_value || std::ranges::none_of(kKnowledge, is_name)) return false;
      plan.models = arguments[++i];
    } else if (arguments[i] == "--seed") {
      if (!has_value) return false;
      plan.first_seed = std::strtoull(arguments[++i].data(), nullptr, 10);
    } else {
      numbers.push_back(std::atoi(arguments[i].data()));
      if (numbers.back() < 1) return false;
    }
  }
  if (!numbers.empty()) plan.games = static_cast<std::uint64_t>(numbers[0]);
  if (numbers.size() > 1) plan.simulations.assign(numbers.begin() + 1, numbers.end());
  if (plan.simulations.empty()) plan.simulations = {250, 1000};
  return true;
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  powderkeg::Plan plan;
  if (!powderkeg::Read({argv + 1, argv + argc}, plan)) {
    std::fprintf(stderr,
                 "expected oracle_match [GAMES [SIMULATIONS...]] [--seed SEED] [--models NAME], "
                 "all positive, NAME one of reset, synchronized, inferred, oracle\n");
    return 2;
  }
  std::printf("simulations  models        games  wins [95 %%]            ties   foretold\n");
  for (const int simulations : plan.simulations) powderkeg::Report(simulations, plan);
  return 0;
}

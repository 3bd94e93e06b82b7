// What must hold for every value of every option, and what the options of the root are for.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <iostream>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <thread>

#include "tests/pommerman/board_reader.h"
#include "tests/search/known_answers.h"
#include "tests/search/search_support.h"
#include "tests/search/settings_from_text.h"

namespace powderkeg {
namespace {

// --- Alone, in batches and in threads ------------------------------------------------------------

// Each option with values besides its default.
const std::vector<std::string>& OptionValues() {
  static const std::vector<std::string> values = {
      "preset=paper",
      "preset=gumbel",
      "simulations=7",
      "tree=two_player",
      "tree=two_player,simulated_opponent=most_dangerous",
      "tree=two_player,simulated_opponent_reach=5",
      "opponents=idle",
      "opponents=random",
      "opponents=harmless",
      "opponents=simple_unbiased",
      "opponents=official_simple",
      "opponents=raw_network",
      "opponents=predicted,tree=two_player",
      "opponents=predicted,predicted_drawn=true",
      "opponents=chosen,tree=two_player",
      "tree=two_player,simulated_moves=as_foretold",
      "tree=two_player,widening=1,widening_exponent=0.4",
      "tree=two_player,simulated_moves=as_foretold,widening=1,terminal_solver=true",
      "opponents=raw_network,leaves_per_batch=4",
      "opponents=raw_network,tree=two_player",
      "mate_model=raw_network",
      "raw_network_depth=2",
      "raw_network_depth=1,tree=two_player,leaves_per_batch=3",
      "memory=reset",
      "memory=synchronized",
      "c_puct_init=0",
      "c_puct_base=50",
      "unvisited_value=0",
      "root_unvisited_value=1",
      "policy_temperature=1",
      "renormalise_priors=true",
      "action_filter=false",
      "caution=100",
      "caution=0,tree=two_player",
      "room=1",
      "hunt=0,room=0",
      "root=gumbel",
      "root=gumbel,tree=two_player",
      "root=gumbel,leaves_per_batch=4",
      "root=gumbel,opponents=raw_network,leaves_per_batch=4",
      "root=gumbel,terminal_solver=true",
      "root=gumbel,full_search_share=0.5",
      "root=gumbel,gumbel_considered=3",
      "root=gumbel,gumbel_first_halving=8",
      "root=gumbel,gumbel_first_halving=8,terminal_solver=true,leaves_per_batch=4",
      "root=gumbel,gumbel_scale=0",
      "root=gumbel,gumbel_c_visit=5",
      "root=gumbel,gumbel_c_scale=0.1",
      "noise_alpha=1",
      "noise_weight=0",
      "exploratory_start=0.3",
      "temperature=1",
      "q_weight=0.5",
      "q_veto=0.4",
      "forced_playouts=2",
      "forced_playouts=2,terminal_solver=true,exploratory_start=0.3",
      "full_search_share=0.5",
      "full_search_share=0,fast_simulations=3",
      "draw_value=-0.5",
      "late_win_value=0",
      "step_limit=false",
      "mate_value_on_death=true",
      "terminal_solver=true",
      "terminal_solver=true,tree=two_player",
      "terminal_solver=true,leaves_per_batch=8",
      "tree_reuse=false",
      "leaves_per_batch=5",
  };
  return values;
}

TEST(SearchOptions, EachIsTested) {
  std::string all;
  for (const std::string& value : OptionValues()) all += "," + value;
  for (const auto& option : SearchOptions()) {
    EXPECT_THAT(all, testing::HasSubstr(StrCat(",", option.name, "="))) << option.name;
  }
}

struct Found {
  std::array<std::uint32_t, kActionCount> visits;
  std::array<std::uint32_t, kActionCount> target;
  std::array<float, kActionCount> values;
  Action best;
  int simulations;
  bool full_search;

  friend bool operator==(const Found&, const Found&) = default;
};

Found Summary(const SearchResult& result) {
  return {result.visits, result.target,      result.values,
          result.best,   result.simulations, result.full_search};
}

constexpr std::size_t kSearches = 12;
constexpr std::size_t kMoves = 2;
using AllFound = std::array<std::array<Found, kMoves>, kSearches>;

State StartOf(std::size_t search) {
  return search % 2 == 0 ? KnownStart(search) : FromText(kEscape);
}

// Plays the first moves of all searches, `together` of them in one batch.
AllFound Play(const SearchSettings& settings, std::size_t together) {
  AllFound found{};
  for (std::size_t first = 0; first < kSearches; first += together) {
    const std::size_t count = std::min(together, kSearches - first);
    std::vector<Search> searches(count, Search(settings, GameSettings{}));
    std::vector<State> states;
    for (std::size_t i = 0; i < count; ++i) states.push_back(StartOf(first + i));
    for (std::size_t move = 0; move < kMoves; ++move) {
      for (std::size_t i = 0; i < count; ++i) {
        searches[i].Start(states[i], ModelsAtStart(settings, 0), Rng(first + i).Split(move));
      }
      FinishTogether(searches);
      for (std::size_t i = 0; i < count; ++i) {
        const SearchResult result = searches[i].Result();
        found[first + i][move] = Summary(result);
        JointAction actions = result.expected_actions;
        actions[0] = result.best;
        Advance({}, actions, states[i]);
        if (!states[i].agents[0].alive) states[i] = StartOf(first + i);
      }
    }
  }
  return found;
}

class EveryOption : public testing::TestWithParam<std::string> {};

TEST_P(EveryOption, FindsTheSameAloneInBatchesAndInThreads) {
  SearchSettings settings = ParseSearchSettings(GetParam());
  settings.simulations = std::min(settings.simulations, 40);
  const AllFound alone = Play(settings, 1);
  EXPECT_EQ(alone, Play(settings, 5));
  EXPECT_EQ(alone, Play(settings, 12));
  std::array<AllFound, 3> found;
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < found.size(); ++i) {
      threads.emplace_back([&, i] { found[i] = Play(settings, i + 1); });
    }
  }
  EXPECT_THAT(found, testing::Each(alone));
}

TEST_P(EveryOption, FindsTheSameAfterOtherSearches) {
  SearchSettings settings = ParseSearchSettings(GetParam());
  settings.simulations = std::min(settings.simulations, 60);
  Search used(settings, GameSettings{});
  UniformEvaluator evaluator;
  used.Start(FromText(kEscape), ModelsAtStart(settings, 0), Rng(1));
  (void)Finish(used, evaluator);
  used.Start(KnownStart(1), ModelsAtStart(settings, 0), Rng(2));
  EXPECT_EQ(Summary(Finish(used, evaluator)),
            Summary(SearchOnce(settings, KnownStart(1), {}, /*seed=*/2)));
}

TEST_P(EveryOption, LearnsFromLegalActionsAlone) {
  const State state = FromText(kEscape);
  SearchSettings settings = ParseSearchSettings(GetParam());
  const SearchResult result = SearchOnce(settings, state);
  ASSERT_TRUE(result.searched);
  const ActionSet legal = LegalActions(state, 0);
  EXPECT_GT(std::accumulate(result.target.begin(), result.target.end(), 0U), 0U);
  for (std::size_t a = 0; a < kActionCount; ++a) {
    const bool allowed = (legal >> a & 1) != 0 || !settings.action_filter;
    EXPECT_TRUE(allowed || result.target[a] == 0) << a;
    EXPECT_TRUE(allowed || static_cast<std::size_t>(result.best) != a) << a;
  }
}

INSTANTIATE_TEST_SUITE_P(SearchOptions, EveryOption, testing::ValuesIn(OptionValues()),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::ranges::replace_if(
                               name, [](char c) { return std::isalnum(c) == 0; }, '_');
                           return name;
                         });

// --- Known answers for every root and both trees -------------------------------------------------

class EveryRoot : public testing::TestWithParam<std::string> {
 protected:
  static SearchSettings With(std::string_view tree, int simulations) {
    std::string text = GetParam();
    text.append(",opponents=idle,noise_weight=0,tree=").append(tree);
    SearchSettings settings = ParseSearchSettings(text);
    settings.simulations = simulations;
    return settings;
  }
};

TEST_P(EveryRoot, FindsTheForcedEscape) {
  const State state = FromText(kEscape);
  ASSERT_THAT(BestActions({}, state, 4), testing::ElementsAre(Action::kRight));
  EXPECT_EQ(SearchOnce(With("one_player", 100), state).best, Action::kRight);
  EXPECT_EQ(SearchOnce(With("two_player", 600), state).best, Action::kRight);
}

TEST_P(EveryRoot, FindsTheForcedKill) {
  const GameSettings game = EndsAfter(10);
  const State state = FromText(kKill);
  ASSERT_THAT(BestActions(game, state, 10), testing::ElementsAre(Action::kBomb));
  EXPECT_EQ(SearchOnce(With("one_player", 5000), state, game).best, Action::kBomb);
  EXPECT_EQ(SearchOnce(With("two_player", 20000), state, game).best, Action::kBomb);
}

// Positions on the way of random play in which some action dies within five steps and some does
// not, by looking at everything.
std::vector<State> DangerousPositions() {
  std::vector<State> positions;
  for (std::uint64_t seed = 0; positions.size() < 20; ++seed) {
    Rng rng(seed);
    State state = KnownStart(seed);
    for (int step = 0; step < 40 && state.agents[0].alive; ++step) {
      JointAction actions{};
      for (AgentId agent = 0; agent < kAgentCount; ++agent) {
        const ActionSet legal = LegalActions(state, agent);
        auto& action = actions[static_cast<std::size_t>(agent)];
        do action = static_cast<Action>(rng.Below(kActionCount));
        while ((legal >> static_cast<int>(action) & 1) == 0);
      }
      if (Advance({}, actions, state).done || !state.agents[0].alive) break;
      const auto best = BestActions({}, state, 5);
      if (best.size() < static_cast<std::size_t>(std::popcount(LegalActions(state, 0))) &&
          BestOutcome({}, state, 5) == 0) {
        positions.push_back(state);
        break;
      }
    }
  }
  return positions;
}

TEST_P(EveryRoot, AvoidsEveryForcedDeath) {
  static const std::vector<State> positions = DangerousPositions();
  const SearchSettings settings = With("one_player", 2000);
  for (const State& state : positions) {
    const SearchResult result = SearchOnce(settings, state);
    EXPECT_THAT(BestActions({}, state, 5), testing::Contains(result.best)) << ToText(state);
  }
}

INSTANTIATE_TEST_SUITE_P(SearchOptions, EveryRoot,
                         testing::Values("root=puct", "root=gumbel", "root=gumbel,gumbel_scale=0",
                                         "root=gumbel,tree_reuse=false,leaves_per_batch=4",
                                         "root=gumbel,gumbel_first_halving=64,leaves_per_batch=8",
                                         "forced_playouts=2", "terminal_solver=true",
                                         "root=gumbel,terminal_solver=true"),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::ranges::replace_if(
                               name, [](char c) { return std::isalnum(c) == 0; }, '_');
                           return name;
                         });

// --- Gumbel root ---------------------------------------------------------------------------------

TEST(GumbelRoot, VisitsFollowTheHalvingAndTheTargetIsTheImprovedPolicy) {
  SearchSettings settings = Quiet(250);
  settings.root = RootSearch::kGumbel;
  const State state = KnownStart(1);
  const SearchResult result = SearchOnce(settings, state);
  std::vector<std::uint32_t> visits(result.visits.begin(), result.visits.end());
  std::erase(visits, 0U);
  ASSERT_EQ(visits.size(), static_cast<std::size_t>(std::popcount(LegalActions(state, 0))));
  EXPECT_EQ(std::accumulate(visits.begin(), visits.end(), 0U), 250U);
  EXPECT_NEAR(std::accumulate(result.target.begin(), result.target.end(), 0.0),
              kImprovedPolicyScale, 3);
}

std::vector<std::uint32_t> Sorted(std::array<std::uint32_t, kActionCount> visits) {
  std::ranges::sort(visits);
  return {visits.begin(), visits.end()};
}

// Whatever is found, the shares are the same; a simulation that has to be tried again loses none.
TEST(GumbelRoot, BatchesAndNetworkModelsDoNotChangeTheShares) {
  SearchSettings settings = Quiet(100);
  settings.root = RootSearch::kGumbel;
  const State state = KnownStart(1);
  const auto expected = Sorted(SearchOnce(settings, state).visits);
  settings.opponents.fill(OpponentModel::kRawNetwork);
  for (const int leaves : {1, 3, 16}) {
    settings.leaves_per_batch = leaves;
    EXPECT_EQ(Sorted(SearchOnce(settings, state).visits), expected) << leaves;
  }
}

// Farther right is better.
class ValuesColumns final : public Evaluator {
 public:
  void Evaluate(const GameSettings&, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const AgentState& self = positions[i].state->agents[0];
      evaluations[i].policy.fill(1.0F / kActionCount);
      evaluations[i].value = static_cast<float>(ColumnOf(self.cell)) / 10;
    }
  }
  [[nodiscard]] std::string name() const override { return "values columns"; }
};

TEST(GumbelRoot, HalvesWhenAllAnswersAreThere) {
  SearchSettings settings = Quiet(8);
  settings.root = RootSearch::kGumbel;
  settings.gumbel_scale = 0;
  std::vector<SearchResult> results;
  for (const int leaves : {1, 8}) {
    settings.leaves_per_batch = leaves;
    Search search(settings, {});
    ValuesColumns evaluator;
    search.Start(FromText(kEscape), ModelsAtStart(settings, 0), Rng(1));
    results.push_back(Finish(search, evaluator));
  }
  EXPECT_EQ(results[0].best, Action::kRight);
  EXPECT_EQ(Summary(results[0]).visits, Summary(results[1]).visits);
}

TEST(GumbelRoot, WithoutGumbelNumbersTheSeedChangesNothing) {
  SearchSettings settings = Quiet(100);
  settings.root = RootSearch::kGumbel;
  settings.gumbel_scale = 0;
  const State state = KnownStart(1);
  EXPECT_EQ(Summary(SearchOnce(settings, state, {}, 1)),
            Summary(SearchOnce(settings, state, {}, 2)));
  settings.gumbel_scale = 1;
  settings.gumbel_considered = 2;
  std::set<std::array<std::uint32_t, kActionCount>> visits;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    visits.insert(SearchOnce(settings, state, {}, seed).visits);
  }
  EXPECT_GT(visits.size(), 1U);
}

TEST(GumbelRoot, KeptVisitsDoNotCountInTheShares) {
  SearchSettings settings = Quiet(120);
  settings.root = RootSearch::kGumbel;
  settings.gumbel_scale = 0;
  Search search(settings, {});
  UniformEvaluator evaluator;
  State state = KnownStart(2);
  const OpponentModels models = ModelsAtStart(settings, 0);
  search.Start(state, models, Rng(1));
  const SearchResult first = Finish(search, evaluator);
  Advance({}, {first.best}, state);
  search.Start(state, models, Rng(2));
  const SearchResult second = Finish(search, evaluator);
  EXPECT_GT(second.reused_visits, 0);
  EXPECT_EQ(second.simulations, 120);
  const int legal = std::popcount(LegalActions(state, 0));
  const auto share =
      static_cast<std::uint32_t>(120 / (legal * std::bit_width(unsigned(legal - 1))));
  for (const std::uint32_t visits : second.visits) EXPECT_TRUE(visits == 0 || visits >= share);
}

// What is found when somebody ends a search of 20,000 simulations.
SearchResult FindInTime(SearchSettings settings, const State& state, const GameSettings& game,
                        int simulations) {
  settings.simulations = 20'000;
  settings.leaves_per_batch = 8;
  Search search(settings, game);
  UniformEvaluator evaluator;
  EvaluationBatch batch;
  search.Start(state, ModelsAtStart(settings, 0, game), Rng(1));
  do {
    EXPECT_TRUE(search.Gather(batch));
    evaluator.Evaluate(game, batch.positions(), batch.AllocateEvaluations());
    search.Scatter(batch);
    batch.Clear();
  } while (search.Result().simulations < simulations);
  return search.Result();
}

double ShareOf(Action action, const SearchResult& result) {
  return static_cast<double>(result.visits[static_cast<std::size_t>(action)]) / result.simulations;
}

TEST(GumbelRoot, UnderAClockIsRightAndLooksAtTheBest) {
  SearchSettings settings = Quiet(1);
  settings.root = RootSearch::kGumbel;
  settings.gumbel_scale = 0;
  settings.gumbel_first_halving = 64;
  for (int cut = 64; cut < 1500; cut += 50) {
    const SearchResult result = FindInTime(settings, FromText(kEscape), {}, cut);
    EXPECT_EQ(result.best, Action::kRight) << cut;
    EXPECT_GE(ShareOf(Action::kRight, result), 0.3) << cut;
  }
  for (int cut = 3000; cut < 9000; cut += 900) {
    const SearchResult result = FindInTime(settings, FromText(kKill), EndsAfter(10), cut);
    EXPECT_EQ(result.best, Action::kBomb) << cut;
    EXPECT_GE(ShareOf(Action::kBomb, result), 0.3) << cut;
  }
}

// --- Playout cap randomisation -------------------------------------------------------------------

TEST(PlayoutCap, ItsShareOfTheSearchesIsFull) {
  const SearchSettings settings =
      ParseSearchSettings("simulations=20,fast_simulations=5,full_search_share=0.25");
  const State state = KnownStart(1);
  int full = 0;
  std::set<std::array<std::uint32_t, kActionCount>> fast_visits;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const SearchResult result = SearchOnce(settings, state, {}, seed);
    EXPECT_EQ(result.simulations, result.full_search ? 20 : 5);
    full += result.full_search ? 1 : 0;
    if (!result.full_search) fast_visits.insert(result.visits);
  }
  EXPECT_NEAR(full, 100, 35);
}

TEST(PlayoutCap, FastSearchesHaveNoNoise) {
  const State state = KnownStart(1);
  for (const std::string root : {"puct", "gumbel"}) {
    const SearchSettings settings = ParseSearchSettings(
        "full_search_share=0,fast_simulations=30,exploratory_start=0.5,forced_playouts=2,"
        "temperature=1,opponents=idle,root=" +
        root);
    const Found first = Summary(SearchOnce(settings, state, {}, 1));
    EXPECT_EQ(first, Summary(SearchOnce(settings, state, {}, 2)));
    EXPECT_FALSE(first.full_search);
  }
}

// --- Forced playouts -----------------------------------------------------------------------------

TEST(ForcedPlayouts, TriedActionsGetTheirShareAndDoNotTeachIt) {
  SearchSettings settings = Quiet(400);
  settings.root_unvisited_value = 1;
  const State state = FromText(kEscape);
  const SearchResult plain = SearchOnce(settings, state);
  settings.forced_playouts = 2;
  const SearchResult forced = SearchOnce(settings, state);
  for (std::size_t a = 0; a < kActionCount; ++a) {
    if ((LegalActions(state, 0) >> a & 1) == 0) continue;
    EXPECT_GE(forced.visits[a] + 1.0, std::sqrt(2.0 * 400 / 6)) << a;
    EXPECT_LE(forced.target[a], forced.visits[a]) << a;
    EXPECT_LE(forced.target[a], plain.visits[a] + 5) << a;
  }
  EXPECT_EQ(forced.target[static_cast<std::size_t>(forced.best)],
            forced.visits[static_cast<std::size_t>(forced.best)]);
  EXPECT_GT(forced.visits[0], plain.visits[0]) << "to stay is certain death";
}

// --- Terminal solver -----------------------------------------------------------------------------

SearchSettings Solving(int simulations) {
  SearchSettings settings = Quiet(simulations);
  settings.terminal_solver = true;
  return settings;
}

// Agent 0 dies in this step whatever it does.
constexpr std::string_view kDoomed = R"(
    0o.........
    ##.........
    ...........
    ...........
    ...........
    ...........
    ...........
    ...........
    ...........
    ...........
    1..........
    bomb (0,1) owner 1 life 1 strength 2
)";

TEST(TerminalSolver, EndsTheSearchOfALostPosition) {
  const SearchResult result = SearchOnce(Solving(500), FromText(kDoomed));
  EXPECT_LT(result.simulations, 10);
  EXPECT_EQ(result.value, -1);
  EXPECT_EQ(SearchOnce(Quiet(500), FromText(kDoomed)).simulations, 500);
}

TEST(TerminalSolver, EndsTheSearchOfAWonPosition) {
  const SearchResult result = SearchOnce(Solving(500), FromText(kBurning));
  EXPECT_EQ(result.simulations, 1);
  EXPECT_EQ(result.value, 1);
  EXPECT_EQ(std::ranges::count(result.target, 0U), kActionCount - 1);
}

TEST(TerminalSolver, AnEnemyThatEscapesIsNotBeaten) {
  SearchSettings settings = Solving(500);
  settings.tree = TreeKind::kTwoPlayer;
  const SearchResult result = SearchOnce(settings, FromText(kBurning));
  EXPECT_EQ(result.simulations, 500);
  EXPECT_LT(result.value, 0.5F);
}

TEST(TerminalSolver, LostActionsAreNeitherChosenNorLearned) {
  const State state = FromText(kEscape);
  const SearchResult result = SearchOnce(Solving(200), state);
  EXPECT_EQ(result.best, Action::kRight);
  EXPECT_EQ(result.target[0], 0U);
  EXPECT_EQ(result.values[0], -1);
  EXPECT_LT(result.visits[0], SearchOnce(Quiet(200), state).visits[0]);
}

TEST(TerminalSolver, ExploratoryStartsSpareLostActions) {
  SearchSettings settings = Solving(400);
  settings.exploratory_start = 1;
  const auto visits = SearchOnce(settings, FromText(kEscape)).visits;
  EXPECT_LT(visits[0], visits[4] / 2);
}

TEST(TerminalSolver, AgreesWithLookingAtEverything) {
  int proven = 0;
  for (std::uint64_t seed = 0; seed < 25; ++seed) {
    State state = KnownStart(seed);
    Rng rng(seed);
    for (int step = 0; step < 25; ++step) {
      JointAction actions{};
      for (Action& action : actions) action = static_cast<Action>(rng.Below(kActionCount));
      if (Advance({}, actions, state).done || !state.agents[0].alive) break;
      const SearchResult result = SearchOnce(Solving(2000), state);
      if (!result.searched) continue;
      const int outcome = BestOutcome({}, state, 4);
      if (outcome != 0) {
        EXPECT_EQ(result.value, static_cast<float>(outcome));
      }
      proven += outcome != 0 ? 1 : 0;
      if (outcome == 0 && result.simulations < 2000) {
        EXPECT_EQ(static_cast<float>(BestOutcome({}, state, 9)), result.value);
      }
    }
  }
  EXPECT_GT(proven, 10);
}

TEST(TerminalSolver, KeepsAWonTree) {
  const SearchSettings settings = Solving(20000);
  Search search(settings, EndsAfter(10));
  UniformEvaluator evaluator;
  State state = FromText(kKill);
  const OpponentModels models = ModelsAtStart(settings, 0);
  for (Outcome outcome; !outcome.done;) {
    ASSERT_TRUE(state.agents[0].alive);
    search.Start(state, models, Rng(state.step));
    const SearchResult result = Finish(search, evaluator);
    EXPECT_TRUE(!result.searched || result.value == 1);
    EXPECT_TRUE(state.step == 0 || result.simulations == 0);
    outcome = Advance(EndsAfter(10), {result.best}, state);
    EXPECT_TRUE(!outcome.done || outcome.rewards[0] == 1);
  }
}

// --- Network models ------------------------------------------------------------------------------

// Every viewer wants to do the action with its own number; remembers who was asked about what.
class Asked final : public Evaluator {
 public:
  void Evaluate(const GameSettings&, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const Position& position = positions[i];
      evaluations[i].policy.fill(0.1F);
      evaluations[i].policy[static_cast<std::size_t>(position.viewer)] = 0.5F;
      evaluations[i].value = 0;
      EXPECT_TRUE(viewers[position.state].insert(position.viewer).second) << "asked twice";
      steps_of_models.insert(position.viewer == 0 ? -1 : position.state->step);
      ++evaluated;
    }
  }
  [[nodiscard]] std::string name() const override { return "asked"; }

  std::map<const State*, std::set<AgentId>> viewers;  // by the node they were asked about
  std::set<int> steps_of_models;
  int evaluated = 0;
};

// One evaluation per new node, and one per living opponent of each node that was stepped from.
TEST(NetworkModels, AreAskedOncePerNodeSteppedFrom) {
  SearchSettings settings = Quiet(500);
  settings.opponents.fill(OpponentModel::kRawNetwork);
  State state = KnownStart(4);
  state.agents[2].alive = false;  // three are left
  Search search(settings, {});
  Asked evaluator;
  search.Start(state, ModelsAtStart(settings, 0), Rng(1));
  const SearchResult result = Finish(search, evaluator);
  int nodes = 0;
  int stepped_from = 0;
  int expected = 0;
  for (const auto& [node, viewers] : evaluator.viewers) {
    EXPECT_TRUE(viewers.contains(0)) << "every node was evaluated for the searching agent";
    ++nodes;
    ++expected;
    if (viewers.size() == 1) continue;
    std::set<AgentId> living = {0};
    for (AgentId agent = 1; agent < kAgentCount; ++agent) {
      if (node->agents[static_cast<std::size_t>(agent)].alive) living.insert(agent);
    }
    EXPECT_EQ(viewers, living);
    ++stepped_from;
    expected += static_cast<int>(living.size()) - 1;
  }
  EXPECT_EQ(evaluator.evaluated, expected);
  EXPECT_LE(nodes, 1 + result.simulations);
  EXPECT_LT(stepped_from, nodes);
  const double ratio = static_cast<double>(evaluator.evaluated) / nodes;
  RecordProperty("evaluations_per_node", std::to_string(ratio));
  std::cout << "three alive: " << nodes << " nodes, " << stepped_from << " stepped from, "
            << evaluator.evaluated << " evaluations: " << ratio << " per node\n";
}

TEST(NetworkModels, ActInTheFirstStepsOnlyWhereAsked) {
  SearchSettings settings = Quiet(300);
  settings.raw_network_depth = 2;
  State state = FromText(R"(
    0..........
    ...........
    ...........
    .....1.....
    ...........
    ...........
    ...........
    ..3.....2..
    ...........
    ...........
    ...........
  )");
  state.step = 5;
  Search search(settings, {});
  Asked evaluator;
  search.Start(state, ModelsAtStart(settings, 0), Rng(1));
  const SearchResult result = Finish(search, evaluator);
  EXPECT_THAT(result.expected_actions,
              testing::ElementsAre(Action::kStop, Action::kUp, Action::kDown, Action::kLeft));
  EXPECT_GT(result.mean_depth, 2);
  EXPECT_THAT(evaluator.steps_of_models, testing::ElementsAre(-1, 5, 6));
}

// Agent 1 is sent up twice by the network. Having seen that, its rule-based model does not think
// itself in a loop, in which it would step at random, and goes for agent 0: up or left.
TEST(NetworkModels, AreRememberedByTheRuleBasedOnesAfterThem) {
  SearchSettings settings = Quiet(400);
  settings.opponents.fill(OpponentModel::kSimpleUnbiased);
  settings.raw_network_depth = 2;
  const State state = FromText(R"(
    0..........
    ...........
    ...........
    ...........
    ...........
    ...........
    .....1.....
    ...........
    ...........
    ...........
    ...........
    agent 0 ammo 0 strength 2
    agent 1 ammo 1 strength 2
  )");
  Search search(settings, {});
  Asked evaluator;
  search.Start(state, ModelsAtStart(settings, 0), Rng(1));
  (void)Finish(search, evaluator);
  int seen = 0;
  for (const auto& [node, viewers] : evaluator.viewers) {
    if (node->step != state.step + 3) continue;
    EXPECT_THAT(node->agents[1].cell, testing::AnyOf(CellAt(3, 5), CellAt(4, 4)));
    ++seen;
  }
  EXPECT_GT(seen, 10);
}

}  // namespace
}  // namespace powderkeg

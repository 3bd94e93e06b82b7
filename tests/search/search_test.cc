#include "actors/search/search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <vector>

#include "actors/search/enemy_moves.h"
#include "tests/pommerman/board_reader.h"
#include "tests/search/known_answers.h"
#include "tests/search/search_support.h"

namespace powderkeg {
namespace {

using testing::Each;

TEST(Search, FindsTheOnlyEscape) {
  const State state = FromText(kEscape);
  ASSERT_THAT(BestActions({}, state, 4), testing::ElementsAre(Action::kRight));
  const SearchResult result = SearchOnce(Quiet(100), state);
  EXPECT_EQ(result.best, Action::kRight);
  EXPECT_LT(result.values[0], -0.7F) << "to stay is certain death";
  EXPECT_GT(result.values[4], -0.5F);
}

TEST(Search, FindsTheOnlyKillBeforeTheStepLimit) {
  const GameSettings game = EndsAfter(10);
  const State state = FromText(kKill);
  ASSERT_THAT(BestActions(game, state, 10), testing::ElementsAre(Action::kBomb));
  const SearchResult result = SearchOnce(Quiet(5000), state, game);
  EXPECT_EQ(result.best, Action::kBomb);
  EXPECT_GT(result.value, 0.5F);
}

TEST(Search, TwoPlayerSearchFindsAKillThatNoMoveOfTheEnemyAverts) {
  SearchSettings settings = Quiet(20000);
  settings.tree = TreeKind::kTwoPlayer;
  const SearchResult result = SearchOnce(settings, FromText(kKill), EndsAfter(10));
  EXPECT_EQ(result.best, Action::kBomb);
  EXPECT_GT(result.value, 0.3F);
}

TEST(Search, TwoPlayerEnemyEscapesWhereAModelWouldDie) {
  const State state = FromText(kBurning);
  const SearchResult idle = SearchOnce(Quiet(50), state);
  EXPECT_GT(idle.value, 0.9F);
  SearchSettings settings = Quiet(500);
  settings.tree = TreeKind::kTwoPlayer;
  EXPECT_LT(SearchOnce(settings, state).value, 0.3F);
}

// --- Ends
// -----------------------------------------------------------------------------------------

TEST(Search, TieAtTheStepLimitIsWorthTheDrawValue) {
  SearchSettings settings = Quiet(20);
  settings.draw_value = -0.25;
  const State state = FromText(kKill);
  EXPECT_FLOAT_EQ(SearchOnce(settings, state, EndsAfter(1)).value, -0.25F);
  settings.step_limit = false;
  EXPECT_FLOAT_EQ(SearchOnce(settings, state, EndsAfter(1)).value, 0) << "the limit is unknown";
}

TEST(Search, AWinIsWorthLessTheLaterItComes) {
  SearchSettings settings = Quiet(50);
  State state = FromText(kBurning);
  const auto value_at = [&](int step) {
    state.step = static_cast<decltype(state.step)>(step);
    return SearchOnce(settings, state).value;
  };
  const float won = value_at(0);
  ASSERT_GT(won, 0.9F);
  EXPECT_FLOAT_EQ(value_at(400), won);
  settings.late_win_value = 0;
  EXPECT_NEAR(value_at(0), won, 0.02);
  EXPECT_NEAR(value_at(400), won / 2, 0.02);
  settings.step_limit = false;
  EXPECT_NEAR(value_at(400), won / 2, 0.02);
  EXPECT_NEAR(value_at(900), 0, 0.02) << "never less than in the last step";
  settings.terminal_solver = true;
  EXPECT_NEAR(value_at(400), 0.5F, 0.02) << "proven";
}

// Agent 0 dies in this step whatever it does; its mate (2) and both enemies live on.
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
    1.........2
    agent 0 ammo 1 strength 2
    bomb (0,1) owner 1 life 1 strength 2
)";

// A constant policy and a value for each viewer.
class ValueByViewer final : public Evaluator {
 public:
  explicit ValueByViewer(std::array<float, kAgentCount> values) : values_(values) {}
  void Evaluate(const GameSettings&, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    for (std::size_t i = 0; i < positions.size(); ++i) {
      evaluations[i].policy.fill(1.0F / kActionCount);
      evaluations[i].value = values_[static_cast<std::size_t>(positions[i].viewer)];
    }
  }
  [[nodiscard]] std::string name() const override { return "value by viewer"; }

 private:
  std::array<float, kAgentCount> values_;
};

float RootValue(const SearchSettings& settings, const GameSettings& game, Evaluator& evaluator) {
  Search search(settings, game);
  search.Start(FromText(kDoomed), ModelsAtStart(settings, 0, game), Rng(1));
  return Finish(search, evaluator, game).value;
}

TEST(Search, OwnDeathIsALossInFreeForAll) {
  ValueByViewer evaluator({0, 0, 0.75F, 0});
  EXPECT_FLOAT_EQ(RootValue(Quiet(30), {}, evaluator), -1);
}

TEST(Search, OwnDeathIsHalfALossInTeamsOrTheNetworkJudgesForTheMate) {
  GameSettings team;
  team.mode = Mode::kTeam;
  ValueByViewer evaluator({0, 0, 0.75F, 0});
  EXPECT_FLOAT_EQ(RootValue(Quiet(30), team, evaluator), -0.5F);
  SearchSettings judged = Quiet(30);
  judged.mate_value_on_death = true;
  EXPECT_FLOAT_EQ(RootValue(judged, team, evaluator), 0.75F);
}

TEST(Search, ValuesOfAnEnemysViewAreNegated) {
  SearchSettings settings = Quiet(1);
  settings.tree = TreeKind::kTwoPlayer;
  Search search(settings, {});
  ValueByViewer evaluator({0.25F, 0.5F, 0, 0});
  search.Start(FromText(kKill), ModelsAtStart(settings, 0), Rng(1));
  const SearchResult result = Finish(search, evaluator);
  EXPECT_FLOAT_EQ(result.evaluator_value, 0.25F);
  EXPECT_FLOAT_EQ(result.values[0], -0.5F) << "one visit: the enemy's ply, agent 1's view";
}

TEST(Search, ForcedMoveNeedsNoSearch) {
  const State state = FromText(R"(
    0#.........
    ##.........
    ...........
    ...........
    ...........
    ...........
    ...........
    ...........
    ...........
    ...........
    ..........1
    agent 0 ammo 0 strength 2
  )");
  Search search(Quiet(50), {});
  search.Start(state, ModelsAtStart(Quiet(50), 0), Rng(1));
  EvaluationBatch batch;
  EXPECT_FALSE(search.Gather(batch));
  EXPECT_EQ(batch.size(), 0U);
  EXPECT_FALSE(search.Result().searched);
  EXPECT_EQ(search.Result().best, Action::kStop);
}

// --- Batches and determinism
// ----------------------------------------------------------------------

TEST(Search, BehavesAsPinned) { EXPECT_EQ(SearchSignature(), 15503040510196361415U); }

TEST(Search, EqualArgumentsGiveEqualResults) {
  const State state = KnownStart(3);
  const SearchResult first = SearchOnce({}, state);
  EXPECT_EQ(first.visits, SearchOnce({}, state).visits);
  EXPECT_NE(first.visits, SearchOnce({}, state, {}, /*seed=*/2).visits) << "noise differs";
}

TEST(Search, AloneAndInALargeBatchAreTheSame) {
  for (const TreeKind tree : {TreeKind::kOnePlayer, TreeKind::kTwoPlayer}) {
    SearchSettings settings;
    settings.tree = tree;
    settings.simulations = 60;
    constexpr std::uint64_t kSearches = 512;
    std::vector<Search> searches;
    for (std::uint64_t seed = 0; seed < kSearches; ++seed) {
      searches.emplace_back(settings, GameSettings{});
      searches.back().Start(KnownStart(seed), ModelsAtStart(settings, 0), Rng(seed));
    }
    FinishTogether(searches);
    for (std::uint64_t seed = 0; seed < kSearches; ++seed) {
      ASSERT_EQ(searches[seed].Result().visits,
                SearchOnce(settings, KnownStart(seed), {}, seed).visits);
    }
  }
}

TEST(Search, SpendsItsSimulations) {
  const SearchResult result = SearchOnce({}, KnownStart(1));
  EXPECT_EQ(result.simulations, 250);
  EXPECT_EQ(std::accumulate(result.visits.begin(), result.visits.end(), 0U), 250U);
  EXPECT_GT(result.mean_depth, 1);
  EXPECT_EQ(result.expected_agents, 0b1110);
}

TEST(Search, MeasuresItsPrincipalVariation) {
  EXPECT_EQ(SearchOnce(Quiet(1), KnownStart(1)).variation_length, 1);
  const SearchResult result = SearchOnce(Quiet(250), KnownStart(1));
  EXPECT_GT(result.variation_length, result.mean_depth);
  SearchSettings plies = Quiet(2);
  plies.tree = TreeKind::kTwoPlayer;
  EXPECT_EQ(SearchOnce(plies, KnownStart(1)).variation_length, 1) << "its plies are one step";
}

TEST(Search, SeveralLeavesFillABatch) {
  SearchSettings settings = Quiet(200);
  settings.leaves_per_batch = 8;
  Search search(settings, {});
  UniformEvaluator evaluator;
  search.Start(KnownStart(1), ModelsAtStart(settings, 0), Rng(1));
  EvaluationBatch batch;
  std::size_t largest = 0;
  int batches = 0;
  while (search.Gather(batch)) {
    largest = std::max(largest, batch.size());
    ++batches;
    evaluator.Evaluate({}, batch.positions(), batch.AllocateEvaluations());
    search.Scatter(batch);
    batch.Clear();
  }
  EXPECT_EQ(largest, 8U);
  EXPECT_LT(batches, 80);
  EXPECT_EQ(search.Result().simulations, 200);
  const auto visits = search.Result().visits;
  EXPECT_EQ(std::accumulate(visits.begin(), visits.end(), 0U), 200U);
}

TEST(Search, AnswersBeforeTheEndToo) {
  Search search(Quiet(1000), {});
  UniformEvaluator evaluator;
  search.Start(FromText(kEscape), ModelsAtStart(Quiet(1000), 0), Rng(1));
  EvaluationBatch batch;
  for (int i = 0; i < 30 && search.Gather(batch); ++i) {
    evaluator.Evaluate({}, batch.positions(), batch.AllocateEvaluations());
    search.Scatter(batch);
    batch.Clear();
  }
  EXPECT_LT(search.Result().simulations, 1000);
  EXPECT_EQ(search.Result().best, Action::kRight);
}

// Agent 0 dies whatever it does: no simulation asks for anything. Somebody with a clock wants to
// hear of it all the same.
TEST(Search, PausesWhereAllSimulationsEndInOutcomes) {
  Search search(Quiet(1000), {});
  UniformEvaluator evaluator;
  search.Start(FromText(kDoomed), ModelsAtStart(Quiet(1000), 0), Rng(1));
  EvaluationBatch batch;
  std::vector<int> simulations;
  while (search.Gather(batch)) {
    evaluator.Evaluate({}, batch.positions(), batch.AllocateEvaluations());
    search.Scatter(batch);
    batch.Clear();
    simulations.push_back(search.Result().simulations);
  }
  EXPECT_THAT(simulations, testing::ElementsAre(0, 256, 512, 768));
  EXPECT_EQ(search.Result().simulations, 1000);
}

TEST(Search, ExploratoryStartsVisitEveryLegalAction) {
  SearchSettings settings = Quiet(300);
  settings.exploratory_start = 1;
  settings.action_filter = false;
  const SearchResult result = SearchOnce(settings, KnownStart(1));
  EXPECT_THAT(result.visits, Each(testing::AllOf(testing::Ge(25U), testing::Le(80U))));
}

TEST(Search, ExploratoryStartsAreNotLearned) {
  SearchSettings settings = Quiet(300);
  const State state = KnownStart(1);
  EXPECT_EQ(SearchOnce(settings, state).target, SearchOnce(settings, state).visits);
  settings.exploratory_start = 0.2;
  const SearchResult result = SearchOnce(settings, state);
  std::uint32_t learned = 0;
  for (std::size_t a = 0; a < kActionCount; ++a) {
    EXPECT_LE(result.target[a], result.visits[a]);
    learned += result.target[a];
  }
  EXPECT_NEAR(learned, 0.8 * 300, 30);
}

TEST(Search, WithoutTheFilterEveryActionIsTried) {
  SearchSettings settings = Quiet(300);
  settings.action_filter = false;
  EXPECT_THAT(SearchOnce(settings, FromText(kEscape)).visits, Each(testing::Ge(1U)));
}

// --- Tree reuse
// ------------------------------------------------------------------------------------

TEST(Search, KeepsTheTreeOfWhatItForesaw) {
  const SearchSettings settings = Quiet(400);
  Search search(settings, {});
  UniformEvaluator evaluator;
  State state = KnownStart(2);
  const OpponentModels models = ModelsAtStart(settings, 0);
  search.Start(state, models, Rng(1));
  const SearchResult first = Finish(search, evaluator);
  Advance({}, {first.best}, state);
  search.Start(state, models, Rng(2));
  const SearchResult second = Finish(search, evaluator);
  EXPECT_EQ(second.reused_visits,
            static_cast<int>(first.visits[static_cast<std::size_t>(first.best)]) - 1);
  EXPECT_EQ(second.simulations, 400);
  EXPECT_EQ(std::accumulate(second.visits.begin(), second.visits.end(), 0U),
            400U + static_cast<unsigned>(second.reused_visits));
}

TEST(Search, StartsAnewWhereItWasSurprised) {
  const SearchSettings settings = Quiet(400);
  Search search(settings, {});
  UniformEvaluator evaluator;
  State state = KnownStart(2);
  const OpponentModels models = ModelsAtStart(settings, 0);
  search.Start(state, models, Rng(1));
  const SearchResult first = Finish(search, evaluator);
  Advance({}, {first.best, Action::kBomb}, state);
  search.Start(state, models, Rng(2));
  const SearchResult second = Finish(search, evaluator);
  EXPECT_EQ(second.reused_visits, 0);
  EXPECT_EQ(second.visits, SearchOnce(settings, state, {}, /*seed=*/2).visits);
}

// --- Models
// ----------------------------------------------------------------------------------------

// Every viewer wants to do the action with its own number; records how it was asked.
class WantsOwnNumber final : public Evaluator {
 public:
  void Evaluate(const GameSettings&, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    largest_batch = std::max(largest_batch, positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i) {
      evaluations[i].policy.fill(0);
      evaluations[i].policy[static_cast<std::size_t>(positions[i].viewer)] = 1;
      evaluations[i].value = 0;
    }
  }
  [[nodiscard]] std::string name() const override { return "wants own number"; }

  std::size_t largest_batch = 0;
};

// Everybody in the open, far from the others.
constexpr const char* kInTheOpen = R"(
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
  )";

// Foretells that the agent i places behind the viewer does action i.
class Foretells final : public Evaluator {
 public:
  void Evaluate(const GameSettings&, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    questions += positions.size();
    for (Evaluation& evaluation : evaluations) {
      evaluation.policy.fill(1.0F / kActionCount);
      evaluation.value = 0;
      for (std::size_t i = 0; i < evaluation.others.size(); ++i) evaluation.others[i][i + 1] = 200;
    }
  }
  [[nodiscard]] std::string name() const override { return "foretells"; }

  std::size_t questions = 0;
};

TEST(Search, PredictedModelsDoWhatTheEvaluationForetells) {
  SearchSettings settings = Quiet(50);
  settings.opponents.fill(OpponentModel::kPredicted);
  const State state = FromText(kInTheOpen);
  Search search(settings, {});
  Foretells evaluator;
  search.Start(state, ModelsAtStart(settings, 0), Rng(1));
  const SearchResult result = Finish(search, evaluator);
  EXPECT_THAT(result.expected_actions,
              testing::ElementsAre(Action::kStop, Action::kUp, Action::kDown, Action::kLeft));
  EXPECT_EQ(result.expected_agents, 0b1110);
  EXPECT_EQ(evaluator.questions, static_cast<std::size_t>(search.tree().size()))
      << "one for each node, none for the models";
}

// The answer to a position tells everybody's moves: one question for each step of the environment,
// none for the enemy's plies.
TEST(Search, PredictedEnemyBranchesWithoutAQuestion) {
  SearchSettings settings = Quiet(300);
  settings.tree = TreeKind::kTwoPlayer;
  settings.opponents.fill(OpponentModel::kPredicted);
  Search search(settings, {});
  Foretells evaluator;
  search.Start(FromText(kInTheOpen), ModelsAtStart(settings, 0), Rng(1));
  const SearchResult result = Finish(search, evaluator);
  EXPECT_EQ(result.simulations, 300);
  EXPECT_EQ(result.expected_agents, 0b1100) << "agent 1 is the closest: it branches";
  std::size_t steps = 0;
  for (NodeIndex index = 0; index < search.tree().size(); ++index) {
    const Node& node = search.tree()[index];
    if (node.mover == 0) {
      steps += node.stage != Node::Stage::kTerminal ? 1 : 0;
      continue;
    }
    EXPECT_EQ(node.prior[node.mover], (node.legal >> node.mover & 1) != 0 ? 200.0F / 255 : 0);
    EXPECT_GT(node.visit_count, 0U) << "no simulation ended in it";
  }
  EXPECT_EQ(evaluator.questions, steps);
  EXPECT_GT(search.tree().size(), static_cast<NodeIndex>(steps) + 10);
}

// One action for each of 3 chances of 4, another for the fourth.
class Doubts final : public Evaluator {
 public:
  void Evaluate(const GameSettings&, std::span<const Position>,
                std::span<Evaluation> evaluations) override {
    for (Evaluation& evaluation : evaluations) {
      evaluation.policy.fill(1.0F / kActionCount);
      evaluation.value = 0;
      for (auto& shares : evaluation.others) shares = {60, 180, 0, 0, 0, 0};
    }
  }
  [[nodiscard]] std::string name() const override { return "doubts"; }
};

TEST(Search, DrawnPredictionsDifferBySeedAndAreLegal) {
  SearchSettings settings = Quiet(1);
  settings.opponents.fill(OpponentModel::kPredicted);
  settings.predicted_drawn = true;
  Doubts evaluator;
  int stops = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    std::array<JointAction, 2> expected;
    for (JointAction& actions : expected) {
      Search search(settings, {});
      search.Start(FromText(kInTheOpen), ModelsAtStart(settings, 0), Rng(seed));
      actions = Finish(search, evaluator).expected_actions;
    }
    EXPECT_EQ(expected[0], expected[1]) << "deterministic";
    for (std::size_t agent = 1; agent < kAgentCount; ++agent) {
      stops += expected[0][agent] == Action::kStop ? 1 : 0;
    }
  }
  EXPECT_NEAR(stops, 150, 40);
}

// The moves of the simulated enemy are outcomes of self's: visited by their probabilities, so that
// their mean is backed up.
TEST(Search, EnemyMovesAsForetoldAreVisitedByTheirShares) {
  SearchSettings settings = Quiet(2000);
  settings.tree = TreeKind::kTwoPlayer;
  settings.opponents.fill(OpponentModel::kPredicted);
  settings.simulated_moves = SimulatedMoves::kAsForetold;
  Search search(settings, {});
  Doubts evaluator;
  search.Start(FromText(kInTheOpen), ModelsAtStart(settings, 0), Rng(1));
  (void)Finish(search, evaluator);
  int seen = 0;
  for (NodeIndex index = 0; index < search.tree().size(); ++index) {
    const Node& ply = search.tree()[index];
    if (ply.side > 0 || ply.visit_count < 20 || (ply.legal >> 1 & 1) == 0) continue;
    EXPECT_NEAR(ply.visits[1], 0.75 * ply.visit_count, 1);
    EXPECT_EQ(ply.visits[0] + ply.visits[1], ply.visit_count);
    ++seen;
  }
  EXPECT_GT(seen, 10);
}

TEST(Search, WideningLooksAtTheLikeliestMovesFirst) {
  SearchSettings settings;
  settings.widening = 1;
  Node ply{};
  ply.legal = 0b001111;
  ply.prior = {0.1F, 0.4F, 0.2F, 0.3F, 0, 0};
  EXPECT_EQ(ConsideredMoves(settings, ply), 0b000010) << "one at least";
  ply.visit_count = 2;  // ceil(sqrt(3))
  EXPECT_EQ(ConsideredMoves(settings, ply), 0b001010);
  ply.visit_count = 100;
  EXPECT_EQ(ConsideredMoves(settings, ply), ply.legal);
  settings.widening = 0;
  ply.visit_count = 0;
  EXPECT_EQ(ConsideredMoves(settings, ply), ply.legal);
}

// Nothing foretold, as of who is out of sight: the steps are one-player ones.
TEST(Search, EnemyOfWhichNothingIsForetoldDoesNotBranch) {
  SearchSettings settings = Quiet(50);
  settings.tree = TreeKind::kTwoPlayer;
  settings.opponents.fill(OpponentModel::kPredicted);
  const SearchResult result = SearchOnce(settings, FromText(kInTheOpen));
  EXPECT_EQ(result.expected_agents, 0b1110);
  EXPECT_EQ(result.expected_actions[1], Action::kStop);
}

TEST(Search, NetworkModelsActByTheirPolicy) {
  SearchSettings settings = Quiet(50);
  settings.opponents.fill(OpponentModel::kRawNetwork);
  const State state = FromText(kInTheOpen);
  Search search(settings, {});
  WantsOwnNumber evaluator;
  search.Start(state, ModelsAtStart(settings, 0), Rng(1));
  const SearchResult result = Finish(search, evaluator);
  EXPECT_THAT(result.expected_actions,
              testing::ElementsAre(Action::kStop, Action::kUp, Action::kDown, Action::kLeft));
  EXPECT_EQ(result.expected_agents, 0b1110);
  EXPECT_EQ(evaluator.largest_batch, 3U) << "the models of a node are asked together";
  EXPECT_EQ(result.simulations, 50);
}

// A policy without doubts would leave the other actions unseen.
TEST(Search, RootUnvisitedValueTriesEveryLegalAction) {
  const State state = KnownStart(1);
  for (const double value : {-1.0, 1.0}) {
    SearchSettings settings = Quiet(50);
    settings.root_unvisited_value = value;
    Search search(settings, {});
    WantsOwnNumber evaluator;
    search.Start(state, ModelsAtStart(settings, 0), Rng(1));
    const SearchResult result = Finish(search, evaluator);
    const auto tried = std::ranges::count_if(result.visits, [](auto visits) { return visits > 0; });
    EXPECT_EQ(tried, value > 0 ? std::popcount(LegalActions(state, 0)) : 1);
  }
}

TEST(Search, RootUnvisitedValueHoldsForKeptTreesToo) {
  SearchSettings settings = Quiet(50);
  settings.root_unvisited_value = 1;
  Search search(settings, {});
  WantsOwnNumber evaluator;
  State state = KnownStart(1);
  search.Start(state, ModelsAtStart(settings, 0), Rng(1));
  (void)Finish(search, evaluator);
  Advance({}, {Action::kStop}, state);
  search.Start(state, ModelsAtStart(settings, 0), Rng(2));
  const SearchResult result = Finish(search, evaluator);
  EXPECT_GT(result.reused_visits, 0);
  for (int action = 0; action < kActionCount; ++action) {
    const bool legal = (LegalActions(state, 0) >> action & 1) != 0;
    EXPECT_EQ(result.visits[static_cast<std::size_t>(action)] > 0, legal) << action;
  }
}

}  // namespace
}  // namespace powderkeg

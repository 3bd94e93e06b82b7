#include <gtest/gtest.h>

#include "actors/play/plain_agents.h"
#include "actors/play/search_agent.h"
#include "common/pommerman/step.h"
#include "tests/play/support.h"
#include "tests/pommerman/board_reader.h"
#include "tests/search/settings_from_text.h"

namespace powderkeg {
namespace {

// Agent 0 in a corner; only down is free.
State CornerState() {
  return FromText(R"(
    0#.........
    .#.........
    ...........
    ...........
    ...........
    ...........
    ...........
    ...........
    ...........
    ...........
    1.........2
    agent 0 ammo 0 strength 2
  )");
}

Observation Seen(const State& state) { return Observe(GameSettings(), state, /*self=*/0); }

TEST(RawNetworkAgent, AsksOnceAndPlaysALegalAction) {
  RawNetworkAgent agent;
  agent.StartGame(GameSettings(), /*self=*/0, Rng(1));
  const State state = CornerState();
  agent.Begin(Seen(state));
  EvaluationBatch batch;
  ASSERT_TRUE(agent.Gather(batch));
  ASSERT_EQ(batch.size(), 1u);
  EXPECT_EQ(batch.positions()[0].viewer, 0);
  // The network likes up, into the edge, then down.
  batch.AllocateEvaluations()[0] = {{0.1F, 0.5F, 0.3F, 0.1F, 0, 0}, 0};
  agent.Scatter(batch);
  EXPECT_FALSE(agent.Gather(batch));
  EXPECT_EQ(agent.action(), Action::kDown);
  EXPECT_EQ(agent.decision(), std::nullopt);
}

TEST(RawNetworkAgent, AsksNothingWhereOneActionIsLegal) {
  RawNetworkAgent agent;
  agent.StartGame(GameSettings(), /*self=*/0, Rng(1));
  State state = CornerState();
  state.rigid.Add(CellAt(1, 0));
  agent.Begin(Seen(state));
  EvaluationBatch batch;
  EXPECT_FALSE(agent.Gather(batch));
  EXPECT_EQ(agent.action(), Action::kStop);
}

void Decide(Agent& agent, Evaluator& evaluator) {
  EvaluationBatch batch;
  while (agent.Gather(batch)) {
    evaluator.Evaluate(GameSettings(), batch.positions(), batch.AllocateEvaluations());
    agent.Scatter(batch);
    batch.Clear();
  }
}

TEST(Agents, ThatThinkSayWhereTheyAreAndRuleBasedOnesAreSilent) {
  const GameSettings radio = GameSettingsFor("PommeRadioCompetition-v2").value();
  State state = CornerState();
  state.step = 4;
  UniformEvaluator evaluator;
  SearchAgent search(ParseSearchSettings("simulations=8"));
  RawNetworkAgent raw;
  RuleBasedAgent rule(PolicyKind::kSimpleUnbiased);
  for (Agent* agent : std::initializer_list<Agent*>{&search, &raw, &rule}) {
    agent->StartGame(radio, /*self=*/0, Rng(1));
    agent->Begin(Observe(radio, state, 0));
    Decide(*agent, evaluator);
    const Message silence{};
    EXPECT_EQ(agent->words(), agent == &rule ? silence : EncodeReport(4, 0, agent->action()));
  }
}

TEST(SearchAgent, TellsItsDecisionAndStatistics) {
  SearchAgent agent(ParseSearchSettings("simulations=32,opponents=idle"));
  agent.StartGame(GameSettings(), /*self=*/0, Rng(1));
  State state = CornerState();
  state.step = 7;
  agent.Begin(Seen(state));
  UniformEvaluator evaluator;
  Decide(agent, evaluator);
  const std::optional<Decision> decision = agent.decision();
  ASSERT_TRUE(decision);
  EXPECT_EQ(decision->step, 7);
  EXPECT_EQ(decision->visits[0] + decision->visits[2], 32);
  EXPECT_TRUE(agent.action() == Action::kStop || agent.action() == Action::kDown);
  EXPECT_EQ(agent.move_statistics().simulations, 32u);
  EXPECT_GT(agent.move_statistics().mean_depth, 0);
  EXPECT_EQ(agent.move_statistics().predicted_agents, 0b0110);
  EXPECT_EQ(agent.move_statistics().prediction[1], Action::kStop);
}

TEST(SearchAgent, AnEnemyThatBranchesInTheTreeIsNotPredicted) {
  SearchAgent agent(ParseSearchSettings("simulations=32,opponents=idle,tree=two_player"));
  agent.StartGame(GameSettings(), /*self=*/0, Rng(1));
  agent.Begin(Seen(CornerState()));
  UniformEvaluator evaluator;
  Decide(agent, evaluator);
  EXPECT_EQ(agent.move_statistics().predicted_agents, 0b0100) << "agent 1 is the closest";
}

TEST(SearchAgent, RecordsTheImprovedPolicyOfAGumbelRoot) {
  SearchAgent agent(ParseSearchSettings("simulations=32,opponents=idle,root=gumbel"));
  agent.StartGame(GameSettings(), /*self=*/0, Rng(1));
  agent.Begin(Seen(CornerState()));
  UniformEvaluator evaluator;
  Decide(agent, evaluator);
  const std::optional<Decision> decision = agent.decision();
  ASSERT_TRUE(decision);
  EXPECT_NEAR(decision->visits[0] + decision->visits[2], kImprovedPolicyScale, 1);
}

TEST(SearchAgent, FastSearchesTellNoPolicy) {
  SearchAgent agent(ParseSearchSettings("opponents=idle,full_search_share=0,fast_simulations=9"));
  agent.StartGame(GameSettings(), /*self=*/0, Rng(1));
  agent.Begin(Seen(CornerState()));
  UniformEvaluator evaluator;
  Decide(agent, evaluator);
  const std::optional<Decision> decision = agent.decision();
  ASSERT_TRUE(decision) << "its value is learned";
  EXPECT_EQ(decision->visits, Decision().visits);
  EXPECT_EQ(agent.move_statistics().simulations, 9u);
}

TEST(SearchAgent, HasNoDecisionWhereOneActionIsLegal) {
  SearchAgent agent(ParseSearchSettings("simulations=32"));
  agent.StartGame(GameSettings(), /*self=*/0, Rng(1));
  State state = CornerState();
  state.rigid.Add(CellAt(1, 0));
  agent.Begin(Seen(state));
  UniformEvaluator evaluator;
  Decide(agent, evaluator);
  EXPECT_EQ(agent.action(), Action::kStop);
  EXPECT_EQ(agent.decision(), std::nullopt);
  EXPECT_EQ(agent.move_statistics().simulations, 0u);
}

TEST(SearchAgent, PlaysEqualGamesEquallyHoweverOftenItPlayedBefore) {
  const SearchSettings settings = ParseSearchSettings("simulations=8");
  GamePlan plan;
  plan.setup = SetupOfSeats(
      {kSimpleUnbiasedSeat, kSearching, kSimpleUnbiasedSeat, kSimpleUnbiasedSeat}, /*seed=*/4);
  SearchAgent agent(settings);
  plan.agents[1] = {&agent, {std::make_shared<UniformEvaluator>(), 0}};
  const GameRecord first = PlayGame(plan);
  EXPECT_EQ(PlayGame(plan), first);
}

TEST(RecordedVisits, AreScaledOnlyWhereTheyDoNotFit) {
  using Visits = std::array<std::uint16_t, kActionCount>;
  EXPECT_EQ(RecordedVisits({0, 1, 250, 65'535, 7, 0}), (Visits{0, 1, 250, 65'535, 7, 0}));
  EXPECT_EQ(RecordedVisits({0, 131'070, 65'536, 0, 0, 1}), (Visits{0, 65'535, 32'768, 0, 0, 0}));
}

}  // namespace
}  // namespace powderkeg

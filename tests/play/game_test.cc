#include "actors/play/game.h"

#include <gtest/gtest.h>

#include <map>
#include <tuple>

#include "actors/play/plain_agents.h"
#include "common/pommerman/step.h"
#include "tests/play/support.h"
#include "tests/search/settings_from_text.h"

namespace powderkeg {
namespace {

std::array<Seat, kAgentCount> FourOf(Seat seat) { return {seat, seat, seat, seat}; }

GamePlan PlanOfSeats(std::array<Seat, kAgentCount> seats, std::uint64_t seed,
                     const GameSettings& settings = {}) {
  GamePlan plan;
  plan.setup = SetupOfSeats(seats, seed, settings);
  return plan;
}

// The loop a reader would write down from the rules.
std::vector<JointAction> StepDirectly(const GameSetup& setup, State& state) {
  std::array<RuleBasedSeat, kAgentCount> seats;
  for (AgentId seat = 0; seat < kAgentCount; ++seat) seats[seat] = RuleBasedSeat(setup, seat);
  state = GenerateStart(setup.settings, setup.start, BoardRng(setup));
  std::vector<JointAction> actions;
  while (!OutcomeOf(setup.settings, state).done) {
    JointAction& joint = actions.emplace_back();
    for (AgentId seat = 0; seat < kAgentCount; ++seat) {
      if (state.agents[seat].alive) joint[seat] = seats[seat].Decide(setup.settings, state);
    }
    Step(setup.settings, joint, state);
  }
  return actions;
}

TEST(Game, OfRuleBasedSeatsEqualsDirectStepping) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const GamePlan plan = PlanOfSeats(FourOf(kSimpleUnbiasedSeat), seed);
    Game game;
    EvaluationBatches batches;
    game.Start(plan);
    ASSERT_FALSE(game.Gather(batches));
    State state;
    EXPECT_EQ(game.record().actions, StepDirectly(plan.setup, state)) << "seed " << seed;
    EXPECT_EQ(game.state(), state);
    EXPECT_EQ(game.record().outcome, OutcomeOf(plan.setup.settings, state));
    EXPECT_EQ(Verify(game.record()), std::nullopt);
    EXPECT_EQ(batches.size(), 0u);
  }
}

// Observation, belief and agent together find what the verifiable seat finds on the true position.
TEST(Game, RuleBasedAgentPlaysAsTheRuleBasedSeat) {
  for (const PolicyKind policy : {PolicyKind::kSimpleUnbiased, PolicyKind::kOfficialSimple}) {
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const Seat seat = {.searches = false, .policy = policy};
      const GamePlan plan = PlanOfSeats(FourOf(seat), seed);
      const GameRecord record = PlayGame(plan);
      RuleBasedAgent agent(policy);
      agent.StartGame(plan.setup.settings, /*self=*/2, SeatRng(plan.setup, 2));
      State state = GenerateStart(plan.setup.settings, plan.setup.start, BoardRng(plan.setup));
      for (const JointAction& actions : record.actions) {
        if (!state.agents[2].alive) break;
        agent.Begin(Observe(plan.setup.settings, state, 2));
        ASSERT_EQ(agent.action(), actions[2]) << "seed " << seed << " step " << state.step;
        Step(plan.setup.settings, actions, state);
      }
    }
  }
}

class GameOfEveryMode : public testing::TestWithParam<const char*> {};

// Agents that see observations and rule-based seats, fog, teams and collapsing boards.
TEST_P(GameOfEveryMode, PassesVerify) {
  const GameSettings settings = GameSettingsFor(GetParam()).value();
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    GamePlan plan = PlanOfSeats({kSimpleUnbiasedSeat, kSearching, kSimpleUnbiasedSeat, kSearching},
                                seed, settings);
    AskingAgent first(/*questions=*/2);
    AskingAgent second(/*questions=*/3);
    const Model model{std::make_shared<UniformEvaluator>(), /*weights_version=*/7};
    plan.agents[1] = {&first, model};
    plan.agents[3] = {&second, model};
    const GameRecord record = PlayGame(plan);
    EXPECT_EQ(Verify(record), std::nullopt) << GetParam() << " seed " << seed;
    EXPECT_TRUE(record.outcome.done);
    EXPECT_EQ(record.tracks[1].weights_version, 7u);
    EXPECT_EQ(record.tracks[2].weights_version, 0u);
    EXPECT_EQ(record.evaluator, "uniform");
  }
}

INSTANTIATE_TEST_SUITE_P(Environments, GameOfEveryMode,
                         testing::Values("PommeFFACompetition-v0", "PommeFFA-v1",
                                         "PommeTeamCompetition-v0", "PommeTeamCompetition-v1",
                                         "PommeRadioCompetition-v2"));

TEST(Game, PassesTheMatesLastWordsOnInRadioGames) {
  const GameSettings radio = GameSettingsFor("PommeRadioCompetition-v2").value();
  for (const GameSettings& settings : {radio, GameSettingsFor("PommeTeam-v0").value()}) {
    GamePlan plan = PlanOfSeats({kSearching, kSimpleUnbiasedSeat, kSearching, kSimpleUnbiasedSeat},
                                /*seed=*/3, settings);
    AskingAgent first(/*questions=*/1);
    AskingAgent second(/*questions=*/2);
    plan.agents[0] = {&first, {std::make_shared<UniformEvaluator>(), 0}};
    plan.agents[2] = {&second, {std::make_shared<UniformEvaluator>(), 0}};
    const GameRecord record = PlayGame(plan);
    ASSERT_GT(first.heard.size(), 3u);
    EXPECT_EQ(first.heard[0], Message{});
    const std::size_t both = std::min(first.heard.size(), second.heard.size());
    for (std::size_t step = 1; step < both; ++step) {
      const auto action = static_cast<std::uint8_t>(record.actions[step - 1][2]);
      EXPECT_EQ(first.heard[step], settings == radio ? (Message{3, action}) : Message{});
    }
  }
}

TEST(Game, WordsFollowFromTheRecord) {
  GamePlan plan = PlanOfSeats({kSearching, kSimpleUnbiasedSeat, kSearching, kSearching},
                              /*seed=*/3, GameSettingsFor("PommeRadioCompetition-v2").value());
  std::vector<std::unique_ptr<Agent>> agents;
  for (const AgentId seat : {0, 2, 3}) {
    agents.push_back(std::make_unique<SearchAgent>(ParseSearchSettings("simulations=4")));
    plan.agents[seat] = {agents.back().get(), {std::make_shared<UniformEvaluator>(), 0}};
  }
  Game game;
  EvaluationBatches batches;
  std::map<int, State> positions;
  game.Start(plan);
  while (game.Gather(batches)) {
    positions.try_emplace(game.state().step, game.state());
    batches.Evaluate(plan.setup.settings);
    game.Scatter(batches);
    batches.Clear();
  }
  int spoken = 0;
  const auto refusal = Verify(game.record(), [&](const State& state, const JointAction&) {
    const auto played = positions.find(state.step);
    if (played == positions.end()) return;
    EXPECT_EQ(played->second, state) << state.step;
    spoken += state.messages[2] != Message{} ? 1 : 0;
    EXPECT_EQ(state.messages[1], Message{}) << "rule-based agents are silent";
  });
  EXPECT_EQ(refusal, std::nullopt);
  EXPECT_GT(spoken, 3);
}

// Whom the collapse kills had decided already: the record has it stand still, without a decision.
TEST(Game, CollapsesAfterEverybodyDecided) {
  GameSettings settings;
  settings.collapse_steps = {4, 9, 14, 19};
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    GamePlan plan =
        PlanOfSeats({kSearching, kSimpleUnbiasedSeat, kSimpleUnbiasedSeat, kSimpleUnbiasedSeat},
                    seed, settings);
    AskingAgent agent(/*questions=*/1);
    plan.agents[0] = {&agent, {std::make_shared<UniformEvaluator>(), 0}};
    const GameRecord record = PlayGame(plan);
    EXPECT_EQ(Verify(record), std::nullopt) << "seed " << seed;
    EXPECT_LE(record.tracks[0].decisions.size(), 20u);
  }
}

TEST(Game, EndsWhenNoMeasuredSeatCanWinWhereTheSetupSaysSo) {
  int early = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    GamePlan plan = PlanOfSeats(
        {kSearching, kSimpleUnbiasedSeat, kSimpleUnbiasedSeat, kSimpleUnbiasedSeat}, seed);
    plan.setup.to_the_end = false;
    AskingAgent agent(/*questions=*/0);  // plays at random: blows itself up
    plan.agents[0] = {&agent, {std::make_shared<UniformEvaluator>(), 0}};
    const GameRecord record = PlayGame(plan);
    EXPECT_EQ(Verify(record), std::nullopt);
    EXPECT_EQ(record.tracks[0].decisions.size(), record.actions.size());
    if (record.outcome.done) continue;
    ++early;
    EXPECT_EQ(OutcomeFor(record, 0), -1);
  }
  EXPECT_GT(early, 5);
}

TEST(Game, OfSeatsThatNobodyMeasuresIsPlayedOut) {
  GamePlan plan = PlanOfSeats(FourOf(kSimpleUnbiasedSeat), /*seed=*/3);
  plan.setup.to_the_end = false;
  EXPECT_TRUE(PlayGame(plan).outcome.done);
}

TEST(Game, AsksEachSeatsOwnEvaluator) {
  GamePlan plan = PlanOfSeats({kSearching, kSearching, {}, {}}, /*seed=*/1);
  AskingAgent first(/*questions=*/1);
  AskingAgent second(/*questions=*/2);
  plan.agents[0] = {&first, {std::make_shared<ConstantEvaluator>(0.25F), 3}};
  plan.agents[1] = {&second, {std::make_shared<ConstantEvaluator>(-0.5F), 4}};
  const GameRecord record = PlayGame(plan);
  for (const auto& [seat, value, version] : {std::tuple(0, 0.25F, 3u), {1, -0.5F, 4u}}) {
    EXPECT_EQ(record.tracks[seat].weights_version, version);
    EXPECT_FALSE(record.tracks[seat].decisions.empty());
    for (const Decision& decision : record.tracks[seat].decisions) {
      EXPECT_EQ(decision.value, value);
      EXPECT_EQ(decision.weights_version, version);
    }
  }
}

TEST(Game, SetModelAnswersThoseWhoTakeNewWeightsFromThenOn) {
  GamePlan plan = PlanOfSeats({kSearching, kSearching, {}, {}}, /*seed=*/1);
  AskingAgent agent(/*questions=*/1);
  AskingAgent other(/*questions=*/1);
  plan.agents[0] = {&agent, {std::make_shared<ConstantEvaluator>(0.25F), 3}, true};
  plan.agents[1] = {&other, {std::make_shared<ConstantEvaluator>(0.5F), 2}};
  Game game;
  EvaluationBatches batches;
  game.Start(plan);
  for (int round = 0; game.Gather(batches); ++round) {
    batches.Evaluate(plan.setup.settings);
    game.Scatter(batches);
    batches.Clear();
    if (round == 1) game.SetModel({std::make_shared<ConstantEvaluator>(0.75F), 4});
  }
  const GameRecord& record = game.record();
  const std::vector<Decision>& decisions = record.tracks[0].decisions;
  ASSERT_GT(decisions.size(), 3u);
  EXPECT_EQ(record.tracks[0].weights_version, 3u);
  EXPECT_EQ(decisions[0].weights_version, 3u);
  EXPECT_EQ(decisions[0].value, 0.25F);
  EXPECT_EQ(decisions[2].weights_version, 4u);
  EXPECT_EQ(decisions[2].value, 0.75F);
  for (const Decision& decision : record.tracks[1].decisions) EXPECT_EQ(decision.value, 0.5F);
}

TEST(Game, CountsWhatHappenedAtASeat) {
  const GamePlan plan = PlanOfSeats(FourOf(kSimpleUnbiasedSeat), /*seed=*/5);
  Game game;
  EvaluationBatches batches;
  game.Start(plan);
  ASSERT_FALSE(game.Gather(batches));
  State state = GenerateStart(plan.setup.settings, plan.setup.start, BoardRng(plan.setup));
  std::array<SeatStatistics, kAgentCount> expected{};
  for (const JointAction& actions : game.record().actions) {
    for (AgentId seat = 0; seat < kAgentCount; ++seat) {
      if (!state.agents[seat].alive) continue;
      ++expected[seat].moves;
      ++expected[seat].actions[static_cast<std::size_t>(actions[seat])];
    }
    Step(plan.setup.settings, actions, state);
  }
  for (AgentId seat = 0; seat < kAgentCount; ++seat) {
    EXPECT_EQ(game.statistics(seat).moves, expected[seat].moves);
    EXPECT_EQ(game.statistics(seat).actions, expected[seat].actions);
  }
}

TEST(Game, RefusesASearchingSeatWithoutAnAgent) {
  Game game;
  EXPECT_DEATH(game.Start(PlanOfSeats({kSearching, {}, {}, {}}, /*seed=*/1)), "seat 0");
}

}  // namespace
}  // namespace powderkeg

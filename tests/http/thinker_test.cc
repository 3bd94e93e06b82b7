#include "actors/http/thinker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <thread>
#include <vector>

#include "actors/play/evaluation_batches.h"
#include "actors/play/factory.h"
#include "common/base/check.h"
#include "common/pommerman/generate.h"
#include "common/pommerman/step.h"
#include "tests/http/gated_evaluator.h"
#include "tests/http/scripted_agent.h"

namespace powderkeg {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using ::testing::ElementsAre;

using Clock = Thinker::Clock;

constexpr int kEndless = std::numeric_limits<int>::max();
Clock::time_point Never() { return Clock::now() + hours(1); }

// As long as it takes.
Thought Think(Thinker& thinker, const Briefing& briefing) {
  thinker.Start(briefing, Never());
  return thinker.Await(Never());
}

// The answer to a move that cannot begin.
Thought Pass(Thinker& thinker, const Briefing& briefing) {
  thinker.Start(briefing, Never());
  return thinker.Await(Clock::now());
}

class ThinkerTest : public ::testing::Test {
 protected:
  std::unique_ptr<Thinker> MakeThinker(int rounds) {
    const std::vector<Action> actions = {Action::kStop, Action::kUp, Action::kDown, Action::kLeft};
    return std::make_unique<Thinker>(std::make_unique<ScriptedAgent>(diary_, rounds, actions),
                                     evaluator_);
  }
  // A game begins with step 0.
  static Briefing At(std::uint16_t step) {
    State state = GenerateStart({}, {}, Rng(3));
    state.step = step;
    Briefing briefing{.settings = {}, .observation = Observe({}, state, 0)};
    if (step == 0) briefing.new_game = Rng(1);
    return briefing;
  }

  // The answer to a move that is blocked after some rounds.
  Thought ThinkBlocked(Thinker& thinker, int rounds, const Briefing& briefing) {
    evaluator_->CloseAfter(rounds);
    thinker.Start(briefing, Never());
    evaluator_->AwaitCall();
    return thinker.Await(Clock::now());
  }

  AgentDiary diary_;
  std::shared_ptr<GatedEvaluator> evaluator_ = std::make_shared<GatedEvaluator>();
};

TEST_F(ThinkerTest, AnswersWhenTheMoveIsDecided) {
  const auto thinker = MakeThinker(/*rounds=*/3);
  const Thought thought = Think(*thinker, At(0));
  EXPECT_EQ(thought.action, Action::kLeft);
  EXPECT_EQ(thought.words, (Message{4, 7}));
  EXPECT_TRUE(thought.finished);
  EXPECT_TRUE(thought.began.has_value());
  EXPECT_EQ(thought.evaluations, 3U);
  EXPECT_EQ(Think(*thinker, At(1)).evaluations, 3U);
  EXPECT_THAT(diary_.games, ElementsAre(0));
  EXPECT_THAT(diary_.steps, ElementsAre(0, 1));
  EXPECT_EQ(diary_.rounds, 6);
}

TEST_F(ThinkerTest, AMoveMayNeedNoRound) {
  const Thought thought = Think(*MakeThinker(/*rounds=*/0), At(0));
  EXPECT_EQ(thought.action, Action::kStop);
  EXPECT_TRUE(thought.finished);
  EXPECT_EQ(thought.evaluations, 0U);
}

TEST_F(ThinkerTest, BeginsNoRoundThatWouldEndLate) {
  const auto thinker = MakeThinker(kEndless);
  thinker->Start(At(0), Clock::now() + milliseconds(20));
  const Thought thought = thinker->Await(Never());
  EXPECT_TRUE(thought.finished);
  EXPECT_GT(thought.evaluations, 1U);
  thinker->Start(At(1), Clock::now());
  const Thought late = thinker->Await(Never());
  EXPECT_TRUE(late.finished);
  EXPECT_EQ(late.evaluations, 1U) << "there is always one";
}

// Nobody opens the gate before the answer is there.
TEST_F(ThinkerTest, ABlockedRoundDoesNotHoldUpTheAnswer) {
  const auto thinker = MakeThinker(kEndless);
  const Thought thought = ThinkBlocked(*thinker, /*rounds=*/2, At(0));
  EXPECT_EQ(thought.action, Action::kDown) << "the best after two rounds";
  EXPECT_EQ(thought.evaluations, 2U);
  EXPECT_FALSE(thought.finished);
  evaluator_->Open();
}

TEST_F(ThinkerTest, NoAnswerBeforeTheFirstRound) {
  const auto thinker = MakeThinker(/*rounds=*/3);
  const Thought thought = ThinkBlocked(*thinker, /*rounds=*/0, At(0));
  EXPECT_TRUE(thought.began.has_value());
  EXPECT_EQ(thought.action, std::nullopt);
  EXPECT_FALSE(thought.finished);
  evaluator_->Open();
}

TEST_F(ThinkerTest, TheNextMoveWaitsForTheBlockedRound) {
  const auto thinker = MakeThinker(/*rounds=*/3);
  (void)ThinkBlocked(*thinker, /*rounds=*/1, At(0));
  const Thought meanwhile = Pass(*thinker, At(1));
  EXPECT_EQ(meanwhile.began, std::nullopt);
  EXPECT_EQ(meanwhile.action, std::nullopt);
  const std::jthread opener([this] { evaluator_->Open(); });
  const Thought thought = Think(*thinker, At(2));
  EXPECT_EQ(thought.action, Action::kLeft);
  EXPECT_TRUE(thought.finished);
  EXPECT_THAT(diary_.steps, ElementsAre(0, 1, 2)) << "every observation is told";
  EXPECT_EQ(diary_.rounds, 2 + 0 + 3) << "nobody waits for the first two moves any more";
}

TEST_F(ThinkerTest, ANewGameMakesWhatWasNotToldObsolete) {
  const auto thinker = MakeThinker(/*rounds=*/1);
  (void)ThinkBlocked(*thinker, /*rounds=*/0, At(0));
  for (std::uint16_t step = 1; step < 5; ++step) {
    (void)Pass(*thinker, At(step));
  }
  (void)Pass(*thinker, At(0));
  evaluator_->Open();
  EXPECT_TRUE(Think(*thinker, At(1)).finished);
  EXPECT_EQ(diary_.games.size(), 2U);
  EXPECT_THAT(diary_.steps, ElementsAre(0, 0, 1));
}

TEST_F(ThinkerTest, EndsWithTheRoundUnderWay) {
  auto thinker = MakeThinker(kEndless);
  (void)ThinkBlocked(*thinker, /*rounds=*/1, At(0));
  (void)Pass(*thinker, At(1));
  const std::jthread opener([this] { evaluator_->Open(); });
  thinker.reset();
  EXPECT_EQ(diary_.rounds, 2);
}

TEST_F(ThinkerTest, EndsWithoutAnyMove) { (void)MakeThinker(/*rounds=*/1); }

// --- Failures -----------------------------------------------------------------------------------

TEST_F(ThinkerTest, AFailureReachesWhoWaits) {
  const auto thinker = MakeThinker(/*rounds=*/3);
  evaluator_->FailAfter(1, std::make_exception_ptr(Error("no answer")));
  EXPECT_THROW((void)Think(*thinker, At(0)), Error);
  evaluator_->FailAfter(2, std::make_exception_ptr(std::bad_alloc()));
  EXPECT_THROW((void)Think(*thinker, At(1)), std::bad_alloc);
  EXPECT_EQ(Think(*thinker, At(2)).action, Action::kLeft);
  EXPECT_THAT(diary_.steps, ElementsAre(0, 1, 2));
}

TEST_F(ThinkerTest, AFailureAfterTheAnswerIsNotTheNextMoves) {
  const auto thinker = MakeThinker(/*rounds=*/3);
  evaluator_->FailAfter(1, std::make_exception_ptr(Error("no answer")));
  (void)ThinkBlocked(*thinker, /*rounds=*/1, At(0));
  testing::internal::CaptureStderr();
  evaluator_->Open();
  EXPECT_EQ(Think(*thinker, At(1)).action, Action::kLeft);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), ::testing::HasSubstr("reason=\"no answer\""));
}

TEST(ThinkerOfASearch, GoesOnAfterAFailure) {
  const auto evaluator = std::make_shared<GatedEvaluator>();
  Thinker thinker(MakeAgent(ParseAgent("search:simulations=20")), evaluator);
  State state = GenerateStart({}, {}, Rng(3));
  Briefing briefing{.settings = {}, .observation = Observe({}, state, 0), .new_game = Rng(1)};
  for (const int calls : {0, 1, 4}) {
    evaluator->FailAfter(calls, std::make_exception_ptr(Error("no answer")));
    EXPECT_THROW((void)Think(thinker, briefing), Error);
    Step({}, {}, state);
    briefing = {.settings = {}, .observation = Observe({}, state, 0)};
  }
  const Thought thought = Think(thinker, briefing);
  EXPECT_TRUE(thought.finished);
  EXPECT_EQ(thought.statistics.simulations, 20U);
}

class BrokenEvaluator final : public Evaluator {
 public:
  void Evaluate(const GameSettings&, std::span<const Position>,
                std::span<Evaluation> evaluations) override {
    for (Evaluation& evaluation : evaluations) evaluation.value = std::nanf("");
  }
  [[nodiscard]] std::string name() const override { return "broken"; }
};

TEST(ThinkerOfASearch, RefusesAnswersThatAreNoNumbers) {
  Thinker thinker(MakeAgent(ParseAgent("search:simulations=20")),
                  std::make_shared<BrokenEvaluator>());
  const State state = GenerateStart({}, {}, Rng(3));
  const Briefing briefing{.settings = {}, .observation = Observe({}, state, 0), .new_game = Rng(1)};
  EXPECT_THROW((void)Think(thinker, briefing), BadEvaluation);
}

// --- What is cut short leaves no trace ----------------------------------------------------------

// What agent 0 saw of a game among SimpleUnbiased agents, `steps` at most while it lived.
std::vector<Briefing> RecordedGame(const GameSettings& settings, std::size_t steps,
                                   std::uint64_t seed) {
  std::array<std::unique_ptr<Agent>, kAgentCount> agents;
  State state = GenerateStart(settings, {}, Rng(seed));
  for (AgentId id = 0; id < kAgentCount; ++id) {
    agents[id] = MakeAgent(ParseAgent("simple_unbiased"));
    agents[id]->StartGame(settings, id, Rng(id));
  }
  std::vector<Briefing> briefings;
  while (briefings.size() < steps && state.agents[0].alive) {
    briefings.push_back({.settings = settings, .observation = Observe(settings, state, 0)});
    JointAction actions{};
    for (AgentId id = 0; id < kAgentCount; ++id) {
      if (!state.agents[id].alive) continue;
      agents[id]->Begin(Observe(settings, state, id));
      actions[id] = agents[id]->action();
    }
    Step(settings, actions, state);
  }
  briefings.front().new_game = Rng(5);
  return briefings;
}

// The belief and the models are those of an agent that was never disturbed; without tree reuse its
// search then is the same.
TEST(ThinkerOfASearch, KnowsTheGameAfterMovesThatWereCutShort) {
  const GameSettings settings = GameSettingsFor("PommeTeamCompetition-v0").value();
  constexpr std::size_t kSteps = 24;
  std::vector<Briefing> briefings;
  for (std::uint64_t seed = 1; briefings.size() < kSteps; ++seed) {
    briefings = RecordedGame(settings, kSteps, seed);
  }
  const AgentSpec agent = ParseAgent("search:simulations=60,leaves_per_batch=1,tree_reuse=false");
  const auto evaluator = std::make_shared<GatedEvaluator>();
  Thinker disturbed(MakeAgent(agent), evaluator);
  Thinker undisturbed(MakeAgent(agent), std::make_shared<UniformEvaluator>());
  int cut_short = 0;
  for (std::size_t i = 0; i < briefings.size(); ++i) {
    const Thought expected = Think(undisturbed, briefings[i]);
    const bool searches = expected.evaluations > 10;  // one a round
    if (i % 4 == 1 && searches) {                     // cut short in its third round
      evaluator->CloseAfter(2);
      disturbed.Start(briefings[i], Never());
      evaluator->AwaitCall();
      EXPECT_FALSE(disturbed.Await(Clock::now()).finished);
      ++cut_short;
      // The next move is only told.
      EXPECT_EQ(Pass(disturbed, briefings[++i]).began, std::nullopt);
      (void)Think(undisturbed, briefings[i]);
      evaluator->Open();
    } else {
      const Thought thought = Think(disturbed, briefings[i]);
      EXPECT_EQ(thought.action, expected.action);
      EXPECT_EQ(thought.statistics.simulations, expected.statistics.simulations);
      EXPECT_EQ(thought.statistics.mean_depth, expected.statistics.mean_depth);
      EXPECT_EQ(thought.statistics.prediction, expected.statistics.prediction);
    }
  }
  EXPECT_GT(cut_short, 3);
}

}  // namespace
}  // namespace powderkeg

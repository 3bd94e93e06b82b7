#include "actors/http/agent_service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "actors/play/factory.h"
#include "actors/runner/runner_json.h"
#include "common/base/check.h"
#include "common/pommerman/generate.h"
#include "common/pommerman/step.h"
#include "tests/http/gated_evaluator.h"
#include "tests/http/scripted_agent.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kSuccess = R"({"success":true})";
constexpr int kEndless = std::numeric_limits<int>::max();
constexpr const char* kReward = R"({"reward": "-1"})";

class AgentServiceTest : public ::testing::Test {
 protected:
  // A service around an agent that asks `rounds` times a move.
  std::unique_ptr<AgentService> Serve(int rounds, const ServiceSettings& settings = {}) {
    return std::make_unique<AgentService>(std::make_unique<ScriptedAgent>(diary_, rounds),
                                          evaluator_, settings);
  }
  std::string Body(AgentId agent, int step, const GameSettings& settings = {}) const {
    State state = GenerateStart(settings, {}, Rng(3));
    state.step = static_cast<std::uint16_t>(step);
    state.messages[2] = {3, static_cast<std::uint8_t>(step % 8)};
    return ActionBody(settings, Observe(settings, state, agent));
  }

  AgentDiary diary_;
  std::shared_ptr<GatedEvaluator> evaluator_ = std::make_shared<GatedEvaluator>();
};

TEST_F(AgentServiceTest, PlaysAGameInTheRunnersOrder) {
  const auto service = Serve(/*rounds=*/3);
  EXPECT_EQ(service->Ping().body, kSuccess);
  EXPECT_EQ(service->InitAgent(InitBody(2, Mode::kFreeForAll)).body, kSuccess);
  for (int step = 0; step < 3; ++step) {
    const ServiceReply reply = service->Act(Body(2, step));
    EXPECT_EQ(reply.status, 200);
    EXPECT_EQ(reply.body, R"({"action":5})");
  }
  EXPECT_EQ(service->EndEpisode(kReward).body, kSuccess);
  EXPECT_EQ(service->Shutdown().body, kSuccess);
  EXPECT_THAT(diary_.games, ElementsAre(2));
  EXPECT_THAT(diary_.steps, ElementsAre(0, 1, 2));
  EXPECT_EQ(diary_.rounds, 9);
  EXPECT_EQ(service->statistics().moves, 3U);
  EXPECT_EQ(service->statistics().games, 1U);
  EXPECT_EQ(service->statistics().refused, 0U);
}

TEST_F(AgentServiceTest, AnythingButTheNextStepStartsAnew) {
  const auto service = Serve(0);
  (void)service->InitAgent(InitBody(0, Mode::kFreeForAll));
  for (const int step : {0, 1, 3, 4, 4, 0}) EXPECT_EQ(service->Act(Body(0, step)).status, 200);
  EXPECT_EQ(diary_.games.size(), 4U);  // at 0, 3, the second 4, and 0
}

TEST_F(AgentServiceTest, InitAndEpisodeEndStartAnew) {
  const auto service = Serve(0);
  (void)service->InitAgent(InitBody(0, Mode::kFreeForAll));
  (void)service->Act(Body(0, 0));
  (void)service->InitAgent(InitBody(0, Mode::kFreeForAll));
  (void)service->Act(Body(0, 1));
  EXPECT_EQ(diary_.games.size(), 2U);
  (void)service->EndEpisode(kReward);
  (void)service->Act(Body(0, 2));  // the next game has no /init_agent
  EXPECT_EQ(diary_.games.size(), 3U);
  (void)service->InitAgent(InitBody(1, Mode::kTeam));  // the next battle does
  const GameSettings team = GameSettingsFor("PommeTeamCompetition-v0").value();
  EXPECT_EQ(service->Act(Body(1, 0, team)).status, 200);
  EXPECT_THAT(diary_.games, ElementsAre(0, 0, 0, 1));
  EXPECT_EQ(diary_.settings, team);
}

TEST_F(AgentServiceTest, ChangedSettingsStartAnew) {
  const auto service = Serve(0);
  (void)service->InitAgent(InitBody(1, Mode::kTeam));
  (void)service->Act(Body(1, 0, GameSettingsFor("PommeTeamCompetition-v0").value()));
  (void)service->Act(Body(1, 1, GameSettingsFor("PommeTeam-v0").value()));
  EXPECT_EQ(diary_.games.size(), 2U);
}

// An older version of the environment: what it leaves out is said once, and its steps are counted.
TEST_F(AgentServiceTest, CountsTheStepsOfARunnerThatDoesNot) {
  const auto service = Serve(0);
  auto object = ObservationObject({}, Observe({}, GenerateStart({}, {}, Rng(3)), 0));
  for (const char* key : {"flame_life", "bomb_moving_direction", "game_env", "step_count"}) {
    object.erase(key);
  }
  (void)service->InitAgent(InitBody(0, Mode::kFreeForAll));
  testing::internal::CaptureStderr();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(service->Act(ActionBody(object)).status, 200);
  (void)service->EndEpisode(kReward);
  EXPECT_EQ(service->Act(ActionBody(object)).status, 200);
  EXPECT_THAT(diary_.steps, ElementsAre(0, 1, 2, 0));
  EXPECT_EQ(diary_.games.size(), 2U);
  const std::string log = testing::internal::GetCapturedStderr();
  const std::string said = "keys=\"game_env, bomb_moving_direction, flame_life, step_count\"";
  EXPECT_THAT(log, HasSubstr(said));
  EXPECT_EQ(log.find(said), log.rfind(said)) << log;
}

TEST_F(AgentServiceTest, RefusesWhatIsOutOfOrder) {
  const auto service = Serve(0);
  const ServiceReply early = service->Act(Body(0, 0));
  EXPECT_EQ(early.status, 409);
  EXPECT_EQ(early.body, R"({"action":0,"error":"an action was asked for before /init_agent"})");
  EXPECT_EQ(service->EndEpisode(kReward).status, 409);
  (void)service->InitAgent(InitBody(1, Mode::kFreeForAll));
  EXPECT_THAT(service->Act(Body(0, 0)).body, HasSubstr("announced agent 1, the observation is of"));
  const GameSettings team = GameSettingsFor("PommeTeam-v0").value();
  EXPECT_THAT(service->Act(Body(1, 0, team)).body, HasSubstr("announced game_type 1"));
  (void)service->Shutdown();
  EXPECT_EQ(service->Act(Body(1, 0)).status, 409);
  EXPECT_TRUE(diary_.games.empty());
  EXPECT_EQ(service->statistics().refused, 5U);
}

TEST_F(AgentServiceTest, RefusesWhatItCannotRead) {
  const auto service = Serve(0);
  EXPECT_EQ(service->InitAgent("").status, 400);
  EXPECT_EQ(service->InitAgent(InitBody(7, Mode::kTeam)).status, 400);
  (void)service->InitAgent(InitBody(0, Mode::kFreeForAll));
  const ServiceReply reply = service->Act("{}");
  EXPECT_EQ(reply.status, 400);
  EXPECT_EQ(reply.body, R"({"action":0,"error":"the key obs is missing"})");
  EXPECT_EQ(service->EndEpisode("[]").status, 400);
  EXPECT_EQ(service->Act(Body(0, 0)).status, 200) << "a bad request must not end the game";
}

TEST_F(AgentServiceTest, AnswersInTimeWithWhatItHas) {
  const auto service = Serve(kEndless, {.move_time = milliseconds(200), .seed = 1});
  (void)service->InitAgent(InitBody(0, Mode::kFreeForAll));
  const auto start = AgentService::Clock::now();
  EXPECT_EQ(service->Act(Body(0, 0)).status, 200);
  EXPECT_LT(AgentService::Clock::now() - start, milliseconds(2000));
  EXPECT_GT(service->statistics().evaluations, 1U);
}

TEST_F(AgentServiceTest, ABlockedEvaluatorDoesNotHoldUpTheAnswer) {
  const auto service = Serve(kEndless, {.move_time = milliseconds(300)});
  (void)service->InitAgent(InitBody(0, Mode::kFreeForAll));
  evaluator_->CloseAfter(2);
  EXPECT_EQ(service->Act(Body(0, 0)).body, R"({"action":5})") << "the agent's, after two rounds";
  ServiceStatistics statistics = service->statistics();
  EXPECT_EQ(statistics.cut_short, 1U);
  EXPECT_EQ(statistics.stand_ins, 0U);
  EXPECT_EQ(statistics.late_moves, 1U) << "300 ms are more than 100";
  EXPECT_EQ(statistics.evaluations, 2U);
  EXPECT_GE(statistics.slowest_move.total(), milliseconds(300));
  evaluator_->Open();
  EXPECT_EQ(service->Act(Body(0, 1)).status, 200);
  statistics = service->statistics();
  EXPECT_EQ(statistics.moves, 2U);
  EXPECT_GT(statistics.evaluations, 3U);
}

// Request after request while the first one's round does not end.
TEST_F(AgentServiceTest, WithoutAnEndedRoundARuleStandsIn) {
  const auto service = Serve(/*rounds=*/3, {.move_time = milliseconds(20)});
  (void)service->InitAgent(InitBody(0, Mode::kFreeForAll));
  evaluator_->CloseAfter(0);
  for (int step = 0; step < 3; ++step) EXPECT_EQ(service->Act(Body(0, step)).status, 200);
  EXPECT_EQ(service->statistics().stand_ins, 3U);
  EXPECT_EQ(service->statistics().cut_short, 3U);
  EXPECT_EQ(service->statistics().evaluations, 0U);
  EXPECT_EQ(service->EndEpisode(kReward).status, 200) << "needs no agent";
  evaluator_->Open();
  const auto arrival = AgentService::Clock::now() + std::chrono::seconds(1);  // enough time
  EXPECT_EQ(service->Act(Body(0, 0), arrival).body, R"({"action":5})");
  EXPECT_EQ(service->statistics().stand_ins, 3U);
}

TEST_F(AgentServiceTest, AStandInsActionsAreLegal) {
  const auto service = Serve(kEndless, {.move_time = milliseconds(1)});
  (void)service->InitAgent(InitBody(0, Mode::kFreeForAll));
  evaluator_->CloseAfter(0);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    State state = GenerateStart({}, {}, Rng(seed));
    for (int step = 0; step < 8 && state.agents[0].alive; ++step) {
      const std::string body = ActionBody({}, Observe({}, state, 0));
      const int action = nlohmann::json::parse(service->Act(body).body)["action"];
      EXPECT_NE(LegalActions(state, 0) >> action & 1, 0) << "seed " << seed << ", step " << step;
      JointAction actions{static_cast<Action>(action)};
      for (AgentId id = 1; id < kAgentCount; ++id) actions[id] = static_cast<Action>(rng.Below(6));
      Step({}, actions, state);
    }
  }
  EXPECT_EQ(service->statistics().stand_ins, service->statistics().moves);
  evaluator_->Open();
}

TEST_F(AgentServiceTest, ALateRequestIsAnsweredAtOnce) {
  const auto service = Serve(kEndless, {.move_time = milliseconds(1)});
  (void)service->InitAgent(InitBody(0, Mode::kFreeForAll));
  evaluator_->CloseAfter(0);
  const auto arrival = AgentService::Clock::now() - std::chrono::seconds(1);
  EXPECT_EQ(service->Act(Body(0, 0), arrival).status, 200);
  EXPECT_EQ(service->statistics().stand_ins, 1U);
  evaluator_->Open();
}

TEST_F(AgentServiceTest, WithoutAClockAnAnswerIsWaitedFor) {
  const auto service = Serve(/*rounds=*/3);
  (void)service->InitAgent(InitBody(0, Mode::kFreeForAll));
  evaluator_->CloseAfter(1);
  const std::jthread opener([this] {
    evaluator_->AwaitCall();
    evaluator_->Open();
  });
  EXPECT_EQ(service->Act(Body(0, 0)).body, R"({"action":5})");
  EXPECT_EQ(service->statistics().cut_short, 0U);
  EXPECT_EQ(service->statistics().evaluations, 3U);
}

TEST_F(AgentServiceTest, AFailureIsThrownToTheRequestAndTheNextIsServed) {
  const auto service = Serve(/*rounds=*/3);
  (void)service->InitAgent(InitBody(0, Mode::kFreeForAll));
  evaluator_->FailAfter(1, std::make_exception_ptr(Error("no answer")));
  EXPECT_THROW((void)service->Act(Body(0, 0)), Error);
  EXPECT_EQ(service->Act(Body(0, 1)).body, R"({"action":5})");
  EXPECT_EQ(service->statistics().moves, 1U);
}

TEST_F(AgentServiceTest, WarmingUpPlaysAFewMovesThatDoNotCount) {
  const auto service = Serve(/*rounds=*/2);
  service->WarmUp();
  EXPECT_THAT(diary_.games, ElementsAre(0));
  EXPECT_THAT(diary_.steps, ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(service->statistics().moves, 0U);
  EXPECT_EQ(service->statistics().evaluations, 0U);
  (void)service->InitAgent(InitBody(2, Mode::kFreeForAll));
  EXPECT_EQ(service->Act(Body(2, 4)).status, 200);
  EXPECT_THAT(diary_.games, ElementsAre(0, 2)) << "the first move of a real game starts anew";
}

TEST_F(AgentServiceTest, UnderAClockTheFirstGameOfAModeIsRehearsed) {
  const auto service = Serve(kEndless, {.move_time = milliseconds(1), .seed = 1});
  (void)service->InitAgent(InitBody(3, Mode::kTeamRadio));
  EXPECT_EQ(diary_.settings, GameSettingsFor("PommeRadioCompetition-v2"));
  EXPECT_THAT(diary_.games, ElementsAre(0));
  EXPECT_EQ(service->statistics().games, 0U);
  EXPECT_EQ(service->statistics().evaluations, 0U);
}

TEST(AgentServiceOfASearch, RehearsesEveryModeUnderAClock) {
  AgentService service(MakeAgent(ParseAgent("search:simulations=20000,leaves_per_batch=8")),
                       std::make_shared<UniformEvaluator>(), {.move_time = milliseconds(1)});
  service.WarmUp();
  for (const Mode mode : {Mode::kFreeForAll, Mode::kTeam, Mode::kTeamRadio, Mode::kOneVsOne}) {
    EXPECT_EQ(service.InitAgent(InitBody(1, mode)).status, 200);
  }
  const GameSettings settings = GameSettingsFor("OneVsOne-v0").value();
  const State state = GenerateStart(settings, {}, Rng(3));
  EXPECT_EQ(service.Act(ActionBody(settings, Observe(settings, state, 1))).status, 200);
}

TEST_F(AgentServiceTest, CountsWhereTheTimeWent) {
  const auto service = Serve(/*rounds=*/3);
  (void)service->InitAgent(InitBody(0, Mode::kFreeForAll));
  const auto arrival = AgentService::Clock::now() - milliseconds(150);
  EXPECT_EQ(service->Act(Body(0, 0), arrival).status, 200);
  EXPECT_EQ(service->Act(Body(0, 1)).status, 200);
  const ServiceStatistics statistics = service->statistics();
  EXPECT_EQ(statistics.moves, 2U);
  EXPECT_GE(statistics.late_moves, 1U);
  EXPECT_GE(statistics.slowest_move.read, milliseconds(150));
  EXPECT_GE(statistics.slowest_move.total(), statistics.slowest_move.read);
  EXPECT_EQ(statistics.evaluations, 6U);
  EXPECT_EQ(statistics.searches, 0U) << "the scripted agent knows no simulations";
}

TEST(AgentServiceOfASearch, CountsItsSimulations) {
  AgentService service(MakeAgent(ParseAgent("search:simulations=20,tree_reuse=false")),
                       std::make_shared<UniformEvaluator>(), {});
  (void)service.InitAgent(InitBody(0, Mode::kFreeForAll));
  const State state = GenerateStart({}, {}, Rng(3));
  EXPECT_EQ(service.Act(ActionBody({}, Observe({}, state, 0))).status, 200);
  EXPECT_EQ(service.statistics().searches, 1U);
  EXPECT_EQ(service.statistics().simulations, 20U);
  EXPECT_GT(service.statistics().evaluations, 1U);
}

// --- Boards that no game can reach ---------------------------------------------------------------

// Anything anywhere, as long as the arrays agree with each other.
void FillCell(Cell cell, Rng& rng, Observation& observation) {
  constexpr std::array kStatic = {CellValue::kPassage,       CellValue::kRigid,
                                  CellValue::kWood,          CellValue::kExtraBomb,
                                  CellValue::kIncreaseRange, CellValue::kKick};
  switch (rng.Below(5)) {
    case 0:
      observation.board[cell] = CellValue::kFlames;
      observation.flame_life[cell] = static_cast<std::uint8_t>(1 + rng.Below(3));
      break;
    case 1:
      observation.board[cell] = CellValue::kBomb;
      observation.bomb_life[cell] = static_cast<std::uint8_t>(1 + rng.Below(9));
      observation.bomb_blast_strength[cell] = static_cast<std::uint8_t>(1 + rng.Below(10));
      observation.bomb_moving_direction[cell] = static_cast<Direction>(rng.Below(5));
      break;
    default: observation.board[cell] = kStatic[rng.Below(kStatic.size())]; break;
  }
}

// Living agents, agent 0 among them, on random cells, perhaps on bombs.
void PlaceAgents(Rng& rng, Observation& observation) {
  for (AgentId id = 0; id < kAgentCount; ++id) {
    observation.alive[id] = id == 0 || rng.Below(3) != 0;
    auto cell = static_cast<Cell>(rng.Below(kCellCount));
    while (observation.board[cell] >= CellValue::kAgent0) cell = (cell + 1) % kCellCount;
    if (!observation.alive[id]) continue;
    observation.board[cell] = AgentValue(id);
    observation.flame_life[cell] = 0;
    if (id == 0) observation.position = static_cast<std::uint8_t>(cell);
  }
}

Observation ImpossibleObservation(Rng& rng) {
  Observation observation{};
  for (Cell cell = 0; cell < kCellCount; ++cell) FillCell(cell, rng, observation);
  PlaceAgents(rng, observation);
  observation.blast_strength = static_cast<std::uint8_t>(1 + rng.Below(10));
  observation.ammo = static_cast<std::uint8_t>(rng.Below(11));
  observation.can_kick = rng.Below(2) == 0;
  observation.step = static_cast<std::uint16_t>(rng.Below(800));
  return observation;
}

// Fog of no shape that the environment has.
void Befog(Rng& rng, Observation& observation) {
  for (int i = 0; i < 40; ++i) {
    const auto cell = static_cast<Cell>(rng.Below(kCellCount));
    if (observation.board[cell] < CellValue::kAgent0) observation.board[cell] = CellValue::kFog;
  }
}

TEST(AgentServiceOnImpossibleBoards, ASearchAnswersOrTheBoardIsRefused) {
  Rng rng(5);
  for (const char* environment : {"PommeFFACompetition-v0", "PommeFFA-v1", "PommeTeam-v0"}) {
    const GameSettings settings = GameSettingsFor(environment).value();
    AgentService service(MakeAgent(ParseAgent("search:simulations=20")),
                         std::make_shared<UniformEvaluator>(), {});
    (void)service.InitAgent(InitBody(0, settings.mode));
    int answered = 0;
    std::uint16_t step = 0;
    for (int board = 0; board < 300; ++board) {
      Observation observation = ImpossibleObservation(rng);
      // Two boards of three pretend to be the next step of the last one.
      if (board % 3 != 0) observation.step = static_cast<std::uint16_t>((step + 1) % 900);
      if (board % 50 >= 40) Befog(rng, observation);
      step = observation.step;
      const ServiceReply reply = service.Act(ActionBody(settings, observation));
      ASSERT_TRUE(reply.status == 200 || reply.status == 400) << reply.body;
      answered += reply.status == 200 ? 1 : 0;
    }
    EXPECT_GT(answered, 250) << environment;
  }
}

// --- Radio --------------------------------------------------------------------------------------

TEST_F(AgentServiceTest, PassesWordsOnInBothDirections) {
  const GameSettings radio = GameSettingsFor("PommeRadioCompetition-v2").value();
  const auto service = Serve(0);
  (void)service->InitAgent(InitBody(0, Mode::kTeamRadio));
  for (int step = 1; step < 3; ++step) {
    EXPECT_EQ(service->Act(Body(0, step, radio)).body, R"({"action":[5,6,7]})");
  }
  EXPECT_THAT(diary_.heard, ElementsAre(Message{3, 1}, Message{3, 2}));
}

TEST_F(AgentServiceTest, WithoutRadioNobodyTalks) {
  const GameSettings team = GameSettingsFor("PommeTeamCompetition-v0").value();
  const auto service = Serve(0);
  (void)service->InitAgent(InitBody(0, Mode::kTeam));
  EXPECT_EQ(service->Act(Body(0, 1, team)).body, R"({"action":5})");
  EXPECT_THAT(diary_.heard, ElementsAre(Message{}));
}

}  // namespace
}  // namespace powderkeg

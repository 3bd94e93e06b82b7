#include "common/record/game_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "common/record/rule_based_seat.h"

namespace powderkeg {
namespace {

using ::testing::HasSubstr;

enum class End : std::uint8_t { kOfficial, kEarly };

GameSetup SetupOf(std::array<bool, kAgentCount> searches, std::uint64_t seed) {
  GameSetup setup;
  setup.start.corners = StartCorners::kPermuted;
  setup.seed = seed;
  constexpr std::array<PolicyKind, kAgentCount> kPolicies = {
      PolicyKind::kHarmless, PolicyKind::kSimpleUnbiased, PolicyKind::kOfficialSimple,
      PolicyKind::kSimpleUnbiased};
  for (AgentId id = 0; id < kAgentCount; ++id) {
    setup.seats[id] = {.searches = searches[id],
                       .policy = kPolicies[id],
                       .teaches = searches[id] ? Teaches::kSearch : Teaches::kNothing,
                       .measured = searches[id]};
  }
  return setup;
}

// Plays a game whose searching seats are played by SimpleUnbiased, which differ from the others in
// that every fourth move claims no search.
GameRecord Play(GameSetup setup, End end = End::kOfficial) {
  GameRecord record;
  setup.to_the_end = end == End::kOfficial;
  record.setup = setup;
  record.evaluator = "uniform";
  const GameSettings& settings = setup.settings;
  State state = GenerateStart(settings, setup.start, BoardRng(setup));
  std::array<RuleBasedSeat, kAgentCount> seats;
  for (AgentId id = 0; id < kAgentCount; ++id) {
    GameSetup player = setup;
    if (setup.seats[id].searches) player.seats[id] = {.policy = PolicyKind::kSimpleUnbiased};
    seats[id] = RuleBasedSeat(player, id);
  }
  while (!record.outcome.done) {
    const State observed = state;
    Collapse(settings, state);
    JointAction actions{};
    for (AgentId id = 0; id < kAgentCount; ++id) {
      if (!state.agents[id].alive) continue;
      actions[id] = seats[id].Decide(settings, observed);
      if (!setup.seats[id].searches || state.step % 4 == 3) continue;
      Decision decision{.step = state.step};
      decision.visits[static_cast<int>(actions[id])] = 100;
      decision.value = static_cast<float>(id) / 4;
      record.tracks[id].decisions.push_back(decision);
    }
    record.actions.push_back(actions);
    Step(settings, actions, state);
    record.outcome = OutcomeOf(settings, state);
    if (EndsEarly(setup, state)) break;
  }
  return record;
}

// A game in which agent 0 searches and dies early, recorded to its end.
GameRecord LongRecord() {
  for (std::uint64_t seed = 0;; ++seed) {
    GameRecord record = Play(SetupOf({true, false, false, false}, seed));
    const std::vector<Decision>& decisions = record.tracks[0].decisions;
    if (decisions.size() > 30 && decisions.back().step + 20u < record.actions.size()) {
      return record;
    }
  }
}

void ExpectRefused(const GameRecord& record, const std::string& reason) {
  const auto refusal = Verify(record);
  ASSERT_TRUE(refusal) << "expected: " << reason;
  EXPECT_THAT(*refusal, HasSubstr(reason));
}

// Verifies after one change to a true record.
void ExpectRefused(const std::function<void(GameRecord&)>& tamper, const std::string& reason) {
  static const GameRecord kTrue = LongRecord();
  GameRecord record = kTrue;
  tamper(record);
  ExpectRefused(record, reason);
}

TEST(GameRecordTest, PlayedGamesVerify) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const bool second_searches = seed % 2 == 0;
    GameSetup setup = SetupOf({true, second_searches, false, false}, seed);
    if (seed % 4 == 1) setup.settings = *GameSettingsFor("PommeTeamCompetition-v0");
    if (seed % 4 == 2) setup.settings = *GameSettingsFor("PommeFFA-v1");
    if (seed % 4 == 3) setup.settings = *GameSettingsFor("OneVsOne-v0");
    for (const End end : {End::kOfficial, End::kEarly}) {
      const auto refusal = Verify(Play(setup, end));
      EXPECT_EQ(refusal, std::nullopt) << "seed " << seed << ": " << refusal.value_or("");
    }
  }
}

TEST(GameRecordTest, CollapsingBoardsKillAndVerify) {
  GameSetup setup = SetupOf({true, true, false, false}, 1);
  setup.settings.collapse_steps = {20, 30, 40, 50};
  for (setup.seed = 0; setup.seed < 40; ++setup.seed) {
    for (const End end : {End::kOfficial, End::kEarly}) {
      const auto refusal = Verify(Play(setup, end));
      EXPECT_EQ(refusal, std::nullopt) << refusal.value_or("");
    }
  }
}

TEST(GameRecordTest, AnObserverSeesEveryStepBeforeItIsPlayed) {
  const GameRecord record = LongRecord();
  std::size_t steps = 0;
  EXPECT_EQ(Verify(record,
                   [&](const State& state, const JointAction& actions) {
                     EXPECT_EQ(state.step, steps);
                     EXPECT_EQ(actions, record.actions[steps]);
                     ++steps;
                   }),
            std::nullopt);
  EXPECT_EQ(steps, record.actions.size());
}

TEST(GameRecordTest, ActionsOfRuleBasedSeatsMustBeTheirs) {
  ExpectRefused([](GameRecord& r) { r.actions[5][1] = Action::kBomb; },
                "step 5: agent 1: action 5, but simple_unbiased plays");
}

TEST(GameRecordTest, EveryChangedActionIsRefused) {
  const GameRecord record = Play(SetupOf({false, false, false, true}, 3), End::kEarly);
  ASSERT_EQ(Verify(record), std::nullopt);
  for (std::size_t step = 0; step < record.actions.size(); ++step) {
    for (AgentId id = 0; id < 3; ++id) {
      GameRecord changed = record;
      Action& action = changed.actions[step][id];
      action = static_cast<Action>((static_cast<int>(action) + 1) % kActionCount);
      EXPECT_TRUE(Verify(changed)) << "step " << step << " agent " << id;
    }
  }
}

TEST(GameRecordTest, UnknownActionsAreRefused) {
  ExpectRefused([](GameRecord& r) { r.actions[3][0] = static_cast<Action>(6); },
                "step 3: agent 0: action 6");
  ExpectRefused([](GameRecord& r) { r.actions[3][2] = static_cast<Action>(255); },
                "step 3: agent 2: action 255");
}

TEST(GameRecordTest, TheDeadStop) {
  ExpectRefused([](GameRecord& r) { r.actions.back()[0] = Action::kUp; },
                "agent 0: action 1 of the dead");
}

TEST(GameRecordTest, OtherSeedsStartsAndSettingsAreRefused) {
  ExpectRefused([](GameRecord& r) { ++r.setup.seed; }, "plays");
  ExpectRefused([](GameRecord& r) { r.setup.start.generator = BoardGenerator::kUniform; }, "plays");
  ExpectRefused([](GameRecord& r) { r.setup.start.corners = StartCorners::kOfficial; }, "plays");
  ExpectRefused([](GameRecord& r) { r.setup.settings.mode = Mode::kTeam; }, "step");
  ExpectRefused([](GameRecord& r) { r.setup.settings.view_radius = 2; }, "plays");
  ExpectRefused([](GameRecord& r) { r.setup.settings.collapse_steps = {2, 3, 4, 5}; }, "step");
  ExpectRefused([](GameRecord& r) { r.setup.seats[1].policy = PolicyKind::kIdle; },
                "but idle plays");
  ExpectRefused([](GameRecord& r) { r.setup.seats[0].searches = false; },
                "which teaches no search");
}

TEST(GameRecordTest, SettingsOutOfRangeAreRefused) {
  using Settings = GameSettings;
  const auto refused = [](const std::function<void(Settings&)>& change, const std::string& reason) {
    ExpectRefused([&](GameRecord& r) { change(r.setup.settings); }, reason);
  };
  refused([](Settings& s) { s.mode = static_cast<Mode>(0); }, "mode 0, expected 1 to 4");
  refused([](Settings& s) { s.mode = static_cast<Mode>(200); }, "mode 200");
  refused([](Settings& s) { s.mode = Mode::kOneVsOne; }, "board size 11, expected 8");
  refused([](Settings& s) { s.board_size = 8; }, "board size 8, expected 11");
  refused([](Settings& s) { s.board_size = -1; }, "board size -1");
  refused([](Settings& s) { s.max_steps = 0; }, "max steps 0, expected 1 to 65535");
  refused([](Settings& s) { s.max_steps = std::numeric_limits<int>::max(); }, "max steps");
  refused([](Settings& s) { s.blast_strength_cap = 0; }, "blast strength cap 0");
  refused([](Settings& s) { s.blast_strength_cap = 11; }, "blast strength cap 11");
  refused([](Settings& s) { s.view_radius = -1; }, "view radius -1");
  refused([](Settings& s) { s.view_radius = 11; }, "view radius 11");
  for (int ring = 0; ring < 4; ++ring) {
    refused([&](Settings& s) { s.collapse_steps[ring] = -5; }, "collapse step of ring");
  }
  ExpectRefused([](GameRecord& r) { r.setup.start.generator = static_cast<BoardGenerator>(2); },
                "board generator 2");
  ExpectRefused([](GameRecord& r) { r.setup.start.corners = static_cast<StartCorners>(9); },
                "start corners 9");
  for (AgentId id = 0; id < kAgentCount; ++id) {
    ExpectRefused([&](GameRecord& r) { r.setup.seats[id].policy = static_cast<PolicyKind>(5); },
                  "policy of seat");
  }
}

TEST(GameRecordTest, LengthsOutOfRangeAreRefused) {
  ExpectRefused([](GameRecord& r) { r.actions.clear(); }, "0 steps");
  ExpectRefused([](GameRecord& r) { r.actions.resize(801); }, "801 steps, expected 1 to 800");
  ExpectRefused([](GameRecord& r) { r.evaluator.assign(129, 'x'); }, "evaluator name of 129 bytes");
}

TEST(GameRecordTest, DecisionsMustBelongToLivingSeatsThatTeachTheirSearch) {
  ExpectRefused([](GameRecord& r) { std::swap(r.tracks[0], r.tracks[1]); },
                "decision of agent 1, which teaches no search");
  ExpectRefused([](GameRecord& r) { r.setup.seats[0].teaches = Teaches::kNothing; },
                "decision of agent 0, which teaches no search");
  ExpectRefused([](GameRecord& r) { r.setup.seats[0].teaches = Teaches::kMoves; },
                "decision of agent 0, which teaches no search");
  ExpectRefused(
      [](GameRecord& r) {
        Decision late = r.tracks[0].decisions.back();
        late.step = static_cast<std::uint16_t>(r.actions.size() - 1);
        r.tracks[0].decisions.push_back(late);
      },
      "decision of agent 0, which is dead");
}

TEST(GameRecordTest, DecisionsMustBeInOrder) {
  const auto refused = [](const std::function<void(std::vector<Decision>&)>& tamper,
                          const std::string& reason) {
    ExpectRefused([&](GameRecord& r) { tamper(r.tracks[0].decisions); }, reason);
  };
  refused([](auto& d) { std::swap(d[2], d[3]); }, "out of order");
  refused([](auto& d) { d.push_back(d.back()); }, "out of order");
  refused([](auto& d) { d.back().step = 65535; }, "was not played");
}

TEST(GameRecordTest, DecisionsMayHaveNoPolicyButMustHaveAValue) {
  GameRecord record = Play(SetupOf({true, false, false, false}, 5));
  record.tracks[0].decisions[4].visits = {};
  EXPECT_EQ(Verify(record), std::nullopt);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float value : {1.01f, -1.01f, kNan, kInfinity, -kInfinity}) {
    ExpectRefused([&](GameRecord& r) { r.tracks[0].decisions[4].value = value; },
                  "expected -1 to 1");
  }
}

TEST(GameRecordTest, TheOutcomeMustBeTheTrueOne) {
  const std::string reason = "the outcome is not the true one";
  ExpectRefused([](GameRecord& r) { r.outcome.done = false; }, reason);
  ExpectRefused([](GameRecord& r) { r.outcome.result = static_cast<Result>(7); }, reason);
  ExpectRefused([](GameRecord& r) { r.outcome.winners ^= 1; }, reason);
  for (AgentId id = 0; id < kAgentCount; ++id) {
    ExpectRefused([&](GameRecord& r) { r.outcome.rewards[id] ^= 1; }, reason);
  }
}

TEST(GameRecordTest, NothingFollowsTheEnd) {
  ExpectRefused([](GameRecord& r) { r.actions.push_back({}); }, "the game is over before it");
}

TEST(GameRecordTest, GamesEndByThemselvesOrWhenNoMeasuredAgentCanWin) {
  const GameSetup setup = LongRecord().setup;
  GameRecord record = Play(setup, End::kEarly);
  ASSERT_FALSE(record.outcome.done);
  ASSERT_EQ(Verify(record), std::nullopt);
  const GameRecord whole = Play(setup);
  GameRecord longer = record;
  longer.actions.push_back(whole.actions[record.actions.size()]);
  ExpectRefused(longer, "the game is over before it");
  GameRecord shorter = record;
  shorter.actions.pop_back();
  shorter.outcome.rewards = {};
  std::vector<Decision>& decisions = shorter.tracks[0].decisions;
  while (decisions.back().step >= shorter.actions.size()) decisions.pop_back();
  EXPECT_TRUE(Verify(shorter));
}

// The searcher of a team may die: the game goes on while its mate lives, and counts for both.
TEST(GameRecordTest, ATeamIsMeasuredWhileOneOfItLives) {
  int outlived = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    GameSetup setup = SetupOf({true, false, false, false}, seed);
    setup.settings = *GameSettingsFor("PommeTeamCompetition-v0");
    const GameRecord record = Play(setup, End::kEarly);
    EXPECT_TRUE(record.outcome.done);
    const auto& decisions = record.tracks[0].decisions;
    if (decisions.empty() || decisions.back().step + 5u < record.actions.size()) ++outlived;
  }
  EXPECT_GT(outlived, 3);
}

TEST(GameRecordTest, OutcomesFollowTheOfficialResult) {
  GameRecord record;
  record.setup.seats[0].measured = true;
  EXPECT_EQ(OutcomeFor(record, 0), -1);  // not played on after its death
  EXPECT_EQ(OutcomeFor(record, 1), 0);
  record.outcome = {.done = true, .result = Result::kWin, .winners = 0b1010, .rewards = {}};
  EXPECT_EQ(OutcomeFor(record, 0), -1);
  EXPECT_EQ(OutcomeFor(record, 1), 1);
  EXPECT_EQ(OutcomeFor(record, 3), 1);
  record.outcome = {.done = true, .result = Result::kTie, .winners = 0, .rewards = {}};
  EXPECT_EQ(OutcomeFor(record, 0), 0);
}

TEST(GameRecordTest, GeneratorsOfAGameAreIndependent) {
  GameSetup setup, other;
  other.seed = 1;
  std::vector<std::uint64_t> first = {BoardRng(setup).Next(), BoardRng(other).Next()};
  for (AgentId id = 0; id < kAgentCount; ++id) {
    for (const GameSetup& s : {setup, other}) {
      first.push_back(SeatRng(s, id).Next());
      first.push_back(SearchRng(s, id).Next());
    }
  }
  std::ranges::sort(first);
  EXPECT_EQ(std::ranges::adjacent_find(first), first.end());
}

// Random garbage never crashes and is never accepted.
TEST(GameRecordTest, RandomChangesAreRefusedOrHarmless) {
  const GameRecord record = Play(SetupOf({true, true, false, false}, 9), End::kEarly);
  ASSERT_EQ(Verify(record), std::nullopt);
  Rng rng(1);
  for (int round = 0; round < 300; ++round) {
    GameRecord changed = record;
    const auto step = rng.Below(static_cast<std::uint32_t>(record.actions.size()));
    const auto index = rng.Below(static_cast<std::uint32_t>(record.tracks[1].decisions.size()));
    switch (rng.Below(4)) {
      case 0: changed.actions[step][rng.Below(4)] = static_cast<Action>(rng.Below(256)); break;
      case 1: changed.actions.resize(step); break;
      case 2:
        changed.tracks[1].decisions[index].step = static_cast<std::uint16_t>(rng.Below(900));
        break;
      case 3: changed.setup.seed = rng.Next(); break;
    }
    const auto refusal = Verify(changed);
    EXPECT_EQ(refusal.has_value(), changed != record) << "round " << round;
  }
}

}  // namespace
}  // namespace powderkeg

#include "learner/replay/lessons.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "common/pommerman/belief.h"
#include "common/pommerman/observation.h"
#include "tests/learner/played_games.h"

namespace powderkeg {
namespace {

// Four SimpleUnbiased that all demonstrate.
GameRecord PlayTeachers(std::uint64_t seed, const GameSettings& settings = {}) {
  GameRecord record;
  record.setup.settings = settings;
  record.setup.seed = seed;
  record.setup.to_the_end = false;
  record.setup.seats.fill(
      {.policy = PolicyKind::kSimpleUnbiased, .teaches = Teaches::kMoves, .measured = true});
  State state = GenerateStart(settings, record.setup.start, BoardRng(record.setup));
  std::array<RuleBasedSeat, kAgentCount> seats;
  for (AgentId id = 0; id < kAgentCount; ++id) seats[id] = RuleBasedSeat(record.setup, id);
  while (!record.outcome.done) {
    JointAction& actions = record.actions.emplace_back();
    for (AgentId id = 0; id < kAgentCount; ++id) {
      if (state.agents[id].alive) actions[id] = seats[id].Decide(settings, state);
    }
    Step(settings, actions, state);
    record.outcome = OutcomeOf(settings, state);
  }
  return record;
}

TEST(Lessons, ASearchTeachesWhatItFound) {
  const GameRecord game = PlayGame(3);
  const Lessons lessons = LessonsOf(game);
  const std::vector<Decision>& decisions = game.tracks[0].decisions;
  EXPECT_EQ(lessons.ticket, 3u);
  ASSERT_EQ(lessons.samples.size(), decisions.size());
  for (std::size_t i = 0; i < decisions.size(); ++i) {
    const Sample& sample = lessons.samples[i];
    EXPECT_EQ(sample.visits, decisions[i].visits);
    EXPECT_EQ(sample.search_value, decisions[i].value);
    EXPECT_TRUE(sample.searched);
    EXPECT_EQ(sample.state.step, decisions[i].step);
    EXPECT_EQ(sample.viewer, 0);
    EXPECT_EQ(sample.outcome, OutcomeFor(game, 0));
    EXPECT_TRUE(sample.state.HiddenItems().Empty());
  }
}

TEST(Lessons, ADemonstrationTeachesEveryMoveOfEveryTeacher) {
  const GameRecord game = PlayTeachers(1);
  const Lessons lessons = LessonsOf(game);
  std::size_t moves = 0;
  (void)Verify(game, [&](const State& state, const JointAction&) {
    for (const AgentState& agent : state.agents) moves += agent.alive ? 1 : 0;
  });
  EXPECT_EQ(lessons.samples.size(), moves);
  for (const Sample& sample : lessons.samples) {
    const Action played = game.actions[sample.state.step][sample.viewer];
    std::array<std::uint16_t, kActionCount> expected{};
    expected[static_cast<std::size_t>(played)] = 1;
    EXPECT_EQ(sample.visits, expected);
    EXPECT_FALSE(sample.searched);
  }
  EXPECT_EQ(lessons.play.score.games(), 4u);
}

TEST(Lessons, TellWhatTheOthersDidNext) {
  const GameRecord game = PlayTeachers(2);
  for (const Sample& sample : LessonsOf(game).samples) {
    const JointAction& actions = game.actions[sample.state.step];
    for (std::size_t i = 0; i < sample.others.size(); ++i) {
      EXPECT_EQ(sample.others[i], actions[(sample.viewer + 1 + i) % kAgentCount]);
    }
  }
}

// What the agent believed, not the true position: under fog the two differ.
TEST(Lessons, ShowWhatTheSeatKnew) {
  const GameSettings settings = *GameSettingsFor("PommeTeamCompetition-v0");
  const GameRecord game = PlayTeachers(4, settings);
  const Lessons lessons = LessonsOf(game);
  Belief belief(settings);
  int differences = 0;
  std::size_t next = 0;
  (void)Verify(game, [&](const State& state, const JointAction&) {
    if (!state.agents[2].alive) return;
    belief.Observe(Observe(settings, state, 2));
    while (lessons.samples[next].viewer != 2) ++next;
    EXPECT_EQ(lessons.samples[next].state, belief.state());
    if (!(lessons.samples[next].state == state)) ++differences;
    ++next;
  });
  EXPECT_GT(differences, 20);
}

TEST(Lessons, WhoeverDiedBeforeATieHasLost) {
  int ties = 0;
  for (std::uint64_t seed = 0; ties < 3; ++seed) {
    GameSettings settings;
    settings.max_steps = 150;
    const GameRecord game = PlayTeachers(seed, settings);
    if (game.outcome.result != Result::kTie) continue;
    ++ties;
    std::array<bool, kAgentCount> alive{};
    (void)Verify(game, [&](const State& state, const JointAction&) {
      for (AgentId id = 0; id < kAgentCount; ++id) alive[id] = state.agents[id].alive;
    });
    for (const Sample& sample : LessonsOf(game).samples) {
      EXPECT_EQ(sample.outcome, alive[sample.viewer] ? 0 : -1);
    }
  }
}

TEST(Lessons, AnExamTeachesNothingAndCountsApart) {
  GameRecord game = PlayGame(1);
  game.setup.seats[0].teaches = Teaches::kNothing;
  game.tracks[0].decisions.clear();
  const Lessons lessons = LessonsOf(game);
  EXPECT_TRUE(lessons.samples.empty());
  EXPECT_EQ(lessons.play.games, 0u);
  EXPECT_EQ(lessons.exam.games, 1u);
  EXPECT_EQ(lessons.exam.score.games(), 1u);
}

TEST(Lessons, MatesThatAreMeasuredCountOnce) {
  const Lessons alone = LessonsOf(PlayTeachers(3));
  EXPECT_EQ(alone.play.score.games(), 4u);
  const Lessons teams = LessonsOf(PlayTeachers(3, {.mode = Mode::kTeam}));
  EXPECT_EQ(teams.play.score.games(), 2u) << "sides";
  EXPECT_TRUE(teams.result->finishes[0].counts && teams.result->finishes[1].counts);
  EXPECT_FALSE(teams.result->finishes[2].counts || teams.result->finishes[3].counts);
  EXPECT_EQ(teams.result->finishes[0].outcome, -teams.result->finishes[1].outcome);
}

TEST(Lessons, TheSummaryCountsGamesResultsAndActions) {
  const std::vector<GameRecord> games = {PlayGame(0, /*weights_version=*/0), PlayGame(1, 4)};
  DataSet data_set;
  for (const GameRecord& game : games) AddGame(game, data_set);
  const PlaySummary& summary = data_set.play;
  EXPECT_EQ(summary.games, 2u);
  EXPECT_EQ(summary.decisions, data_set.samples.size());
  EXPECT_EQ(summary.steps, games[0].actions.size() + games[1].actions.size());
  EXPECT_EQ(summary.score.games(), 2u);
  EXPECT_EQ(summary.weights_versions, 1u + 4u) << "0, no network, counts as 1";
  EXPECT_EQ(std::accumulate(summary.actions.begin(), summary.actions.end(), std::uint64_t{0}),
            summary.decisions);
}

TEST(Lessons, AGameThatDoesNotVerifyGivesTheReason) {
  GameRecord game = PlayGame(5);
  game.actions[0][1] = game.actions[0][1] == Action::kStop ? Action::kBomb : Action::kStop;
  EXPECT_THAT(std::get<std::string>(MakeLessons(game)), testing::HasSubstr("step 0: agent 1"));
}

}  // namespace
}  // namespace powderkeg

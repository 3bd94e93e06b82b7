// How the rule-based agents play among themselves, against what was published of the originals. The
// reference figures are of other rules and boards (simple_unbiased) or few games (official_simple),
// so tolerances are wide; the measured figures are printed.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "common/record/rule_based_seat.h"

namespace powderkeg {
namespace {

struct Statistics {
  int games = 0;
  std::array<double, kAgentCount> wins{};  // shares of the games
  double all_dead = 0;
  double step_limit = 0;
  double mean_length = 0;
  double bombs = 0;                            // laid per game
  std::array<double, kActionCount> actions{};  // shares of the decisions
};

void CountEnd(const GameSettings& settings, const State& state, const Outcome& outcome,
              Statistics& sums) {
  for (AgentId id = 0; id < kAgentCount; ++id) sums.wins[id] += outcome.winners >> id & 1;
  if (outcome.result == Result::kTie) {
    (state.step >= settings.max_steps ? sums.step_limit : sums.all_dead) += 1;
  }
  sums.mean_length += state.step;
}

void PlayGame(const GameSetup& setup, Statistics& sums) {
  const GameSettings& settings = setup.settings;
  State state = GenerateStart(settings, setup.start, BoardRng(setup));
  std::array<RuleBasedSeat, kAgentCount> seats;
  for (AgentId id = 0; id < kAgentCount; ++id) seats[id] = RuleBasedSeat(setup, id);
  Outcome outcome;
  while (!outcome.done) {
    JointAction actions{};
    for (AgentId id = 0; id < kAgentCount; ++id) {
      const AgentState& agent = state.agents[id];
      if (!agent.alive) continue;
      actions[id] = seats[id].Decide(settings, state);
      ++sums.actions[static_cast<int>(actions[id])];
      const bool lays = actions[id] == Action::kBomb && agent.ammo > 0;
      if (lays && !state.bomb_cells.Has(agent.cell)) ++sums.bombs;
    }
    outcome = Advance(settings, actions, state);
  }
  CountEnd(settings, state, outcome, sums);
}

Statistics Play(PolicyKind policy, const GameSettings& settings, int games,
                StartCorners corners = StartCorners::kPermuted) {
  GameSetup setup;
  setup.settings = settings;
  setup.start.corners = corners;
  setup.seats.fill({.searches = false, .policy = policy});
  Statistics sums;
  for (int game = 0; game < games; ++game) {
    setup.seed = static_cast<std::uint64_t>(game);
    PlayGame(setup, sums);
  }
  double decisions = 0;
  for (const double count : sums.actions) decisions += count;
  for (double& count : sums.actions) count /= decisions;
  for (double& count : sums.wins) count /= games;
  for (double* sum : {&sums.all_dead, &sums.step_limit, &sums.mean_length, &sums.bombs}) {
    *sum /= games;
  }
  sums.games = games;
  return sums;
}

void Print(const char* what, const Statistics& s) {
  std::printf(
      "%s, %d games: wins %.1f/%.1f/%.1f/%.1f %%, all dead %.1f %%, step limit %.1f %%, length "
      "%.0f, %.1f bombs, actions stop/up/down/left/right/bomb %.1f/%.1f/%.1f/%.1f/%.1f/%.1f %%\n",
      what, s.games, 100 * s.wins[0], 100 * s.wins[1], 100 * s.wins[2], 100 * s.wins[3],
      100 * s.all_dead, 100 * s.step_limit, s.mean_length, s.bombs, 100 * s.actions[0],
      100 * s.actions[1], 100 * s.actions[2], 100 * s.actions[3], 100 * s.actions[4],
      100 * s.actions[5]);
}

TEST(MirrorMatchTest, FourSimpleUnbiasedPlayAsPublished) {
  const Statistics s = Play(PolicyKind::kSimpleUnbiased, {}, 5000);
  Print("simple_unbiased", s);
  constexpr std::array<double, 4> kWins = {.233, .236, .223, .226};
  for (AgentId id = 0; id < kAgentCount; ++id) EXPECT_NEAR(s.wins[id], kWins[id], .03) << id;
  EXPECT_NEAR(s.all_dead, .035, .02);
  EXPECT_NEAR(s.step_limit, .047, .03);
  EXPECT_NEAR(s.mean_length, 222, 30);
  EXPECT_NEAR(s.bombs, 37.8, 6);
  constexpr std::array<double, 6> kActions = {.032, .236, .236, .216, .216, .064};
  for (int a = 0; a < kActionCount; ++a) EXPECT_NEAR(s.actions[a], kActions[a], .015) << a;
}

TEST(MirrorMatchTest, TeamsOfSimpleUnbiasedPlayAsPublished) {
  const Statistics full = Play(PolicyKind::kSimpleUnbiased, {.mode = Mode::kTeam}, 3000);
  Print("simple_unbiased, teams", full);
  EXPECT_NEAR(full.wins[0], .481, .03);
  EXPECT_NEAR(full.wins[1], .474, .03);
  EXPECT_NEAR(full.mean_length, 170, 30);
  const Statistics fog =
      Play(PolicyKind::kSimpleUnbiased, {.mode = Mode::kTeam, .view_radius = 4}, 3000);
  Print("simple_unbiased, teams, 9x9 view", fog);
  EXPECT_NEAR(fog.wins[0], .488, .03);
  EXPECT_NEAR(fog.wins[1], .476, .03);
  EXPECT_NEAR(fog.mean_length, 199, 30);
}

TEST(MirrorMatchTest, FourOfficialSimpleAgentsPlayAsPublished) {
  const Statistics s = Play(PolicyKind::kOfficialSimple, {}, 3000, StartCorners::kOfficial);
  Print("official_simple", s);
  EXPECT_NEAR(s.all_dead + s.step_limit, .20, .08);
  EXPECT_NEAR(s.mean_length, 358, 60);
}

}  // namespace
}  // namespace powderkeg

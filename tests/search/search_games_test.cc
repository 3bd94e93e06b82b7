// What must hold in every search of every kind of game.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "actors/search/search.h"
#include "common/pommerman/observation.h"
#include "tests/search/hash_evaluator.h"
#include "tests/search/search_support.h"
#include "tests/search/settings_from_text.h"

namespace powderkeg {
namespace {

void ExpectSound(const SearchSettings& settings, const State& root, AgentId self,
                 const SearchResult& result) {
  const ActionSet legal = LegalActions(root, self);
  EXPECT_TRUE((legal >> static_cast<int>(result.best) & 1) != 0);
  if (!result.searched) return;
  if (settings.terminal_solver) {
    EXPECT_LE(result.simulations, settings.simulations);
  } else {
    EXPECT_EQ(result.simulations, settings.simulations);
  }
  EXPECT_EQ(std::accumulate(result.visits.begin(), result.visits.end(), 0),
            result.simulations + result.reused_visits);
  EXPECT_GT(std::accumulate(result.target.begin(), result.target.end(), 0U), 0U);
  EXPECT_THAT(result.value, testing::AllOf(testing::Ge(-1.0F), testing::Le(1.0F)));
  for (std::size_t a = 0; a < kActionCount; ++a) {
    EXPECT_THAT(result.values[a], testing::AllOf(testing::Ge(-1.0001F), testing::Le(1.0001F)));
    if ((legal >> a & 1) == 0) {
      EXPECT_EQ(result.visits[a], 0U);
      EXPECT_EQ(result.target[a], 0U);
      EXPECT_EQ(result.priors[a], 0);
    }
  }
}

// Four searching agents play one game to its end.
void PlayGame(const SearchSettings& settings, const GameSettings& game, std::uint64_t seed) {
  State state = GenerateStart(game, {}, Rng(seed));
  HashEvaluator evaluator;
  std::vector<Search> searches(kAgentCount, Search(settings, game));
  std::array<OpponentModels, kAgentCount> models;
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    models[static_cast<std::size_t>(agent)].StartGame(settings, game, agent, Rng(seed));
  }
  for (Outcome outcome; !outcome.done;) {
    State known = state;
    known.RemoveItems(known.HiddenItems());
    JointAction actions{};
    for (AgentId agent = 0; agent < kAgentCount; ++agent) {
      const auto id = static_cast<std::size_t>(agent);
      if (!state.agents[id].alive) continue;
      searches[id].Start(known, models[id], Rng(seed).Split(state.step));
      const SearchResult result = Finish(searches[id], evaluator, game);
      ExpectSound(settings, known, agent, result);
      actions[id] = result.best;
    }
    outcome = Advance(game, actions, state);
    for (std::size_t id = 0; id < kAgentCount; ++id) {
      models[id].ObserveStep({known}, {state}, searches[id].foretold());
    }
  }
}

struct Case {
  const char* name;
  const char* environment;
  const char* options;
};

class SearchGames : public testing::TestWithParam<Case> {};

TEST_P(SearchGames, EverySearchIsSound) {
  const auto game = GameSettingsFor(GetParam().environment);
  ASSERT_TRUE(game.has_value());
  PlayGame(ParseSearchSettings(GetParam().options), *game, /*seed=*/11);
}

INSTANTIATE_TEST_SUITE_P(
    KindsOfGames, SearchGames,
    testing::Values(
        Case{"FreeForAll", "PommeFFACompetition-v0", "simulations=20"},
        Case{"FreeForAllPaper", "PommeFFACompetition-v0", "simulations=20,preset=paper"},
        Case{"CollapsingBoard", "PommeFFA-v1", "simulations=20"},
        Case{"CollapsingBoardTwoPlayer", "PommeFFA-v1", "simulations=20,tree=two_player"},
        Case{"TwoPlayerInReach", "PommeFFACompetition-v0",
             "simulations=20,tree=two_player,simulated_opponent_reach=4,"
             "simulated_opponent=most_dangerous"},
        Case{"Team", "PommeTeam-v0", "simulations=20"},
        Case{"TeamTwoPlayer", "PommeTeam-v0", "simulations=20,tree=two_player,draw_value=-0.5"},
        Case{"TeamFog", "PommeTeamCompetition-v0",
             "simulations=20,opponents=harmless/official_simple/random"},
        Case{"Radio", "PommeRadioCompetition-v2", "simulations=20,opponents=idle"},
        Case{"NetworkModels", "PommeFFACompetition-v0",
             "simulations=20,opponents=raw_network,leaves_per_batch=4"},
        Case{"NetworkModelsTwoPlayer", "PommeTeam-v0",
             "simulations=20,opponents=raw_network/simple_unbiased/raw_network,tree=two_player,"
             "leaves_per_batch=16"},
        Case{"Predicted", "PommeFFA-v1", "simulations=20,opponents=predicted"},
        Case{"PredictedTwoPlayer", "PommeRadioCompetition-v2",
             "simulations=20,opponents=predicted,tree=two_player,leaves_per_batch=4"},
        Case{"Chosen", "PommeRadioCompetition-v2", "simulations=20,opponents=chosen"},
        Case{"Drawn", "PommeFFA-v1",
             "simulations=20,opponents=predicted,predicted_drawn=true,tree=two_player,"
             "simulated_moves=as_foretold,widening=1,leaves_per_batch=4"},
        Case{"Gumbel", "PommeFFACompetition-v0", "simulations=20,root=gumbel"},
        Case{"GumbelTeamTwoPlayer", "PommeTeam-v0",
             "simulations=20,root=gumbel,tree=two_player,leaves_per_batch=4"},
        Case{"GumbelNetworkModels", "PommeFFACompetition-v0",
             "simulations=20,root=gumbel,opponents=raw_network,leaves_per_batch=8"},
        Case{"ForcedPlayouts", "PommeTeamCompetition-v0", "simulations=20,forced_playouts=2"},
        Case{"FastSearches", "PommeFFACompetition-v0",
             "simulations=20,full_search_share=0.5,fast_simulations=20"},
        Case{"Solver", "PommeFFA-v1", "simulations=20,terminal_solver=true"},
        Case{"SolverTwoPlayer", "PommeTeam-v0",
             "simulations=20,terminal_solver=true,tree=two_player,leaves_per_batch=4"},
        Case{"NetworkThenRules", "PommeRadioCompetition-v2",
             "simulations=20,raw_network_depth=2,mate_model=raw_network"},
        Case{"OneVersusOne", "OneVsOne-v0", "simulations=20,tree=two_player"}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace powderkeg

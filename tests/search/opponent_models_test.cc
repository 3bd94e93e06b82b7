#include "actors/search/opponent_models.h"

#include <gtest/gtest.h>

#include "common/pommerman/step.h"
#include "tests/search/search_support.h"

namespace powderkeg {
namespace {

SearchSettings WithMemory(ModelMemory memory) {
  SearchSettings settings;
  settings.memory = memory;
  return settings;
}

TEST(OpponentModels, FollowTheSettingsByPlace) {
  SearchSettings settings;
  settings.opponents = {OpponentModel::kIdle, OpponentModel::kHarmless, OpponentModel::kRandom};
  const OpponentModels models = ModelsAtStart(settings, /*self=*/2);
  EXPECT_EQ(models.self(), 2);
  EXPECT_EQ(models.Of(3).policy, PolicyKind::kIdle);
  EXPECT_EQ(models.Of(0).policy, PolicyKind::kHarmless);
  EXPECT_EQ(models.Of(1).policy, PolicyKind::kRandom);
}

TEST(OpponentModels, TheMateIsTheSecondOfThemOrHasItsOwn) {
  SearchSettings settings;
  settings.opponents = {OpponentModel::kIdle, OpponentModel::kHarmless, OpponentModel::kIdle};
  GameSettings team;
  team.mode = Mode::kTeam;
  EXPECT_EQ(ModelsAtStart(settings, /*self=*/3, team).Of(1).policy, PolicyKind::kHarmless);
  settings.mate_model = OpponentModel::kOfficialSimple;
  EXPECT_EQ(ModelsAtStart(settings, 3, team).Of(1).policy, PolicyKind::kOfficialSimple);
  EXPECT_EQ(ModelsAtStart(settings, 3, team).Of(2).policy, PolicyKind::kIdle);
  EXPECT_EQ(ModelsAtStart(settings, 3).Of(1).policy, PolicyKind::kHarmless) << "no mate";
}

TEST(OpponentModels, SynchronizedMemoryHoldsObservedPositions) {
  OpponentModels models = ModelsAtStart(WithMemory(ModelMemory::kSynchronized), 0);
  const State before = KnownStart(1);
  State after = before;
  after.agents[1].cell = static_cast<std::uint8_t>(before.agents[1].cell + 1);
  models.ObserveStep(before, after);
  const Cell cell = after.agents[1].cell;
  EXPECT_EQ(models.Of(1).memory.recent_count, 1);
  EXPECT_EQ(models.Of(1).memory.recent[0], RememberedPosition(RowOf(cell), ColumnOf(cell)));
}

TEST(OpponentModels, ResetMemoryStaysEmpty) {
  OpponentModels models = ModelsAtStart(WithMemory(ModelMemory::kReset), 0);
  const State state = KnownStart(1);
  models.ObserveStep(state, state);
  EXPECT_EQ(models.Of(1).memory, PolicyMemory());
}

TEST(OpponentModels, DeadAgentsAreNotObserved) {
  OpponentModels models = ModelsAtStart(WithMemory(ModelMemory::kSynchronized), 0);
  State state = KnownStart(1);
  state.agents[3].alive = false;
  models.ObserveStep(state, state);
  EXPECT_EQ(models.Of(3).memory, PolicyMemory());
}

TEST(OpponentModels, StartGameForgets) {
  const SearchSettings settings = WithMemory(ModelMemory::kSynchronized);
  OpponentModels models = ModelsAtStart(settings, 0);
  const State state = KnownStart(1);
  models.ObserveStep(state, state);
  models.StartGame(settings, {}, 0, Rng(7));
  EXPECT_EQ(models.Of(1), ModelsAtStart(settings, 0).Of(1));
}

// Plays games of four SimpleUnbiased agents; the share of actions of agents 1 to 3 that the models
// of agent 0 foretell at the root.
double ShareForetold(ModelMemory memory, int games) {
  const GameSettings game;
  const SearchSettings settings = WithMemory(memory);
  int foretold = 0;
  int all = 0;
  for (std::uint64_t seed = 0; seed < static_cast<std::uint64_t>(games); ++seed) {
    State state = KnownStart(seed);
    OpponentModels models = ModelsAtStart(settings, 0, game, seed + 1000);
    std::array<PolicyTraits, kAgentCount> traits;
    std::array<PolicyMemory, kAgentCount> memories;
    Rng rng(seed);
    for (PolicyTraits& drawn : traits) drawn = PolicyTraits::Draw(rng);
    for (Outcome outcome; !outcome.done && state.agents[0].alive;) {
      JointAction actions{};
      for (std::size_t id = 0; id < kAgentCount; ++id) {
        if (!state.agents[id].alive) continue;
        const PolicyView view{state, game, static_cast<AgentId>(id)};
        actions[id] = Decide(PolicyKind::kSimpleUnbiased, view, traits[id], memories[id], rng);
        if (id == 0) continue;
        const ModelledAgent& model = models.Of(static_cast<AgentId>(id));
        PolicyMemory remembered = model.memory;
        const Action expected =
            Decide(PolicyKind::kSimpleUnbiased, view, model.traits, remembered, rng);
        foretold += expected == actions[id] ? 1 : 0;
        ++all;
      }
      const State before = state;
      outcome = Advance(game, actions, state);
      models.ObserveStep(before, state);
    }
  }
  return static_cast<double>(foretold) / all;
}

TEST(OpponentModels, MemoryDecidesHowWellSimpleUnbiasedIsForetold) {
  EXPECT_NEAR(ShareForetold(ModelMemory::kReset, 40), 0.42, 0.03);
  EXPECT_NEAR(ShareForetold(ModelMemory::kSynchronized, 40), 0.69, 0.03);
  EXPECT_NEAR(ShareForetold(ModelMemory::kInferred, 40), 0.73, 0.03);
}

}  // namespace
}  // namespace powderkeg

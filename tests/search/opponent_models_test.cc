#include "actors/search/opponent_models.h"

#include <gtest/gtest.h>

#include "common/pommerman/belief.h"
#include "common/pommerman/step.h"
#include "common/record/rule_based_seat.h"
#include "common/recorded/recorded_game.h"
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
  models.ObserveStep({before}, {after});
  const Cell cell = after.agents[1].cell;
  EXPECT_EQ(models.Of(1).memory.recent_count, 1);
  EXPECT_EQ(models.Of(1).memory.recent[0], RememberedPosition(RowOf(cell), ColumnOf(cell)));
}

TEST(OpponentModels, ResetMemoryStaysEmpty) {
  OpponentModels models = ModelsAtStart(WithMemory(ModelMemory::kReset), 0);
  const State state = KnownStart(1);
  models.ObserveStep({state}, {state});
  EXPECT_EQ(models.Of(1).memory, PolicyMemory());
}

TEST(OpponentModels, DeadAgentsAreNotObserved) {
  OpponentModels models = ModelsAtStart(WithMemory(ModelMemory::kSynchronized), 0);
  State state = KnownStart(1);
  state.agents[3].alive = false;
  models.ObserveStep({state}, {state});
  EXPECT_EQ(models.Of(3).memory, PolicyMemory());
}

TEST(OpponentModels, StartGameForgets) {
  const SearchSettings settings = WithMemory(ModelMemory::kSynchronized);
  OpponentModels models = ModelsAtStart(settings, 0);
  const State state = KnownStart(1);
  models.ObserveStep({state}, {state});
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
      models.ObserveStep({before}, {state});
    }
  }
  return static_cast<double>(foretold) / all;
}

TEST(OpponentModels, MemoryDecidesHowWellSimpleUnbiasedIsForetold) {
  EXPECT_NEAR(ShareForetold(ModelMemory::kReset, 40), 0.42, 0.03);
  EXPECT_NEAR(ShareForetold(ModelMemory::kSynchronized, 40), 0.69, 0.03);
  EXPECT_NEAR(ShareForetold(ModelMemory::kInferred, 40), 0.77, 0.03);
}

// Agent 1 does what the network says, agent 2 plays SimpleUnbiased.
TEST(OpponentModels, EachIsTakenForWhatExplainsIt) {
  SearchSettings settings;
  settings.opponents.fill(OpponentModel::kChosen);
  const GameSettings game;
  State state = KnownStart(5);
  OpponentModels models = ModelsAtStart(settings, 0);
  EXPECT_EQ(ModelOf(models.Of(1)), OpponentModel::kSimpleUnbiased);
  EXPECT_TRUE(models.Of(1).foretold);
  Rng rng(5);
  const PolicyTraits traits = PolicyTraits::Draw(rng);
  PolicyMemory memory;
  for (int step = 0; step < 40; ++step) {
    Foretelling foretold;
    for (auto& shares : foretold) shares.fill(42);
    ASSERT_TRUE(state.agents[1].alive && state.agents[2].alive);
    JointAction actions{};
    actions[1] = rng.Below(2) == 0 ? Action::kStop : Action::kUp;
    actions[2] = Decide(PolicyKind::kSimpleUnbiased, {state, game, 2}, traits, memory, rng);
    foretold[0] = {0, 10, 0, 0, 0, 0};
    foretold[0][static_cast<std::size_t>(actions[1])] = 200;
    const State before = state;
    Advance(game, actions, state);
    models.ObserveStep({before}, {state}, foretold);
  }
  EXPECT_EQ(ModelOf(models.Of(1)), OpponentModel::kPredicted);
  EXPECT_EQ(ModelOf(models.Of(2)), OpponentModel::kSimpleUnbiased);
  EXPECT_EQ(ModelOf(models.Of(3)), OpponentModel::kIdle);
}

const GameSettings kFog = GameSettingsFor("PommeRadioCompetition-v2").value();

TEST(OpponentModels, WhereAnAgentIsBelievedOutOfSightSaysNothingOfIt) {
  const State state = KnownStart(1);
  State elsewhere = state;
  elsewhere.agents[1].cell = static_cast<std::uint8_t>(state.agents[1].cell + 1);
  const BitBoard unseen =
      ~(BitBoard::Of(state.agents[1].cell) | BitBoard::Of(elsewhere.agents[1].cell));
  OpponentModels models = ModelsAtStart({}, 0, kFog);
  const ModelledAgent at_start = models.Of(1);
  for (int step = 0; step < 100; ++step) {
    models.ObserveStep({state, unseen}, {step % 2 == 0 ? state : elsewhere, unseen});
  }
  EXPECT_EQ(models.Of(1), at_start);
  models.ObserveStep({state}, {elsewhere, unseen});
  EXPECT_EQ(models.Of(1), at_start) << "it went out of sight";
  for (int step = 0; step < 100; ++step) models.ObserveStep({state}, {state});
  EXPECT_EQ(models.Of(1).policy, PolicyKind::kIdle) << "in view it did stand still";
}

TEST(OpponentModels, WhoComesIntoViewRemembersItsPlace) {
  const State state = KnownStart(1);
  const BitBoard unseen = ~BitBoard::Of(state.agents[1].cell);
  for (const OpponentModel model : {OpponentModel::kObserved, OpponentModel::kSimpleUnbiased}) {
    SearchSettings settings = WithMemory(ModelMemory::kInferred);
    settings.opponents.fill(model);
    OpponentModels models = ModelsAtStart(settings, 0, kFog);
    models.ObserveStep({state, unseen}, {state});
    ModelledAgent expected = ModelsAtStart(settings, 0, kFog).Of(1);
    ObserveMove(expected.policy, state.agents[1].cell, state.agents[1].cell, expected.memory);
    EXPECT_EQ(models.Of(1), expected);
    settings.memory = ModelMemory::kReset;
    OpponentModels forgetful = ModelsAtStart(settings, 0, kFog);
    forgetful.ObserveStep({state, unseen}, {state});
    EXPECT_EQ(forgetful.Of(1).memory, PolicyMemory());
  }
}

// What agent 0 sees of a game under fog, step by step.
class Watcher {
 public:
  explicit Watcher(std::uint64_t seed) : models_(ModelsAtStart({}, 0, kFog, seed)) {}

  void Observe(const State& state) {
    const Belief before = belief_;
    belief_.Observe(powderkeg::Observe(kFog, state, 0));
    if (state.step == 0) return;
    models_.ObserveStep({before.state(), before.visible()}, {belief_.state(), belief_.visible()});
  }
  [[nodiscard]] bool Sees(AgentId agent) const {
    return belief_.visible().Has(belief_.state().agents[agent].cell);
  }
  [[nodiscard]] Action Expected(AgentId agent, Rng& rng) const {
    const ModelledAgent& model = models_.Of(agent);
    PolicyMemory memory = model.memory;
    const Cell cell = belief_.state().agents[agent].cell;
    return Decide(model.policy, {belief_.state(), kFog, agent, VisibleCells(kFog, cell)},
                  model.traits, memory, rng);
  }
  [[nodiscard]] const OpponentModels& models() const { return models_; }

 private:
  Belief belief_{kFog};
  OpponentModels models_;
};

// .15 and .15 while what is believed out of sight was taken for seen.
TEST(OpponentModels, SimpleUnbiasedIsRecognisedAndForetoldUnderFog) {
  int foretold = 0;
  int recognised = 0;
  int all = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    GameSetup setup{.settings = kFog, .start = {}, .seats = {}, .seed = seed};
    setup.seats.fill({.searches = false, .policy = PolicyKind::kSimpleUnbiased});
    std::array<RuleBasedSeat, kAgentCount> seats;
    for (AgentId id = 0; id < kAgentCount; ++id) seats[id] = RuleBasedSeat(setup, id);
    State state = GenerateStart(kFog, {}, BoardRng(setup));
    Watcher watcher(seed);
    Rng rng(seed);
    for (Outcome outcome; !outcome.done && state.agents[0].alive;) {
      watcher.Observe(state);
      JointAction actions{};
      for (AgentId id = 0; id < kAgentCount; ++id) {
        if (!state.agents[id].alive) continue;
        actions[id] = seats[id].Decide(kFog, state);
        if (id == 0 || !watcher.Sees(id)) continue;
        foretold += watcher.Expected(id, rng) == actions[id] ? 1 : 0;
        recognised += watcher.models().Of(id).policy == PolicyKind::kSimpleUnbiased ? 1 : 0;
        ++all;
      }
      outcome = Advance(kFog, actions, state);
    }
  }
  EXPECT_GT(foretold, 0.64 * all);
  EXPECT_GT(recognised, 0.80 * all);
}

// Official agents in games of the official environment, seen by agent 0.
TEST(OpponentModels, ModelsOfRecordedAgentsChangeOnlyWithWhatWasInView) {
  RecordedGameReader reader("tests/data/radio.jsonl.gz");
  int unseen = 0;
  int changed = 0;
  for (RecordedGame game; reader.Next(game);) {
    if (!(game.settings == kFog)) continue;
    Watcher watcher(1);
    watcher.Observe(game.start);
    for (const RecordedStep& step : game.steps) {
      const OpponentModels before = watcher.models();
      std::array<bool, kAgentCount> saw{};
      for (AgentId id = 0; id < kAgentCount; ++id) saw[id] = watcher.Sees(id);
      if (!step.state.agents[0].alive) break;
      watcher.Observe(step.state);
      for (AgentId id = 1; id < kAgentCount; ++id) {
        if (!step.state.agents[id].alive) continue;
        const bool equal = watcher.models().Of(id) == before.Of(id);
        if (!watcher.Sees(id)) {
          ASSERT_TRUE(equal) << game.id << " step " << step.state.step << " agent " << id;
          ++unseen;
        } else if (!saw[id]) {
          ASSERT_EQ(watcher.models().Of(id).policy, before.Of(id).policy);
        } else if (!equal) {
          ++changed;
        }
      }
    }
  }
  EXPECT_GT(unseen, 1000);
  EXPECT_GT(changed, 500);
}

}  // namespace
}  // namespace powderkeg

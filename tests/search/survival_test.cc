#include "actors/search/survival.h"

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>

#include "common/base/rng.h"
#include "common/pommerman/symmetry.h"
#include "tests/pommerman/board_reader.h"
#include "tests/pommerman/random_game.h"
#include "tests/search/known_answers.h"
#include "tests/search/search_support.h"
#include "tests/search/settings_from_text.h"

namespace powderkeg {
namespace {

// Missing cells to the right and below are passages.
State Board(std::initializer_list<std::string> rows, const std::string& attributes = "") {
  std::string text;
  for (std::string row : rows) {
    row.resize(kBoardSize, '.');
    text += row + '\n';
  }
  for (std::size_t row = rows.size(); row < kBoardSize; ++row) {
    text += std::string(kBoardSize, '.') + '\n';
  }
  return FromText(text + attributes);
}

constexpr ActionSet SetOf(std::initializer_list<Action> actions) {
  unsigned set = 0;
  for (const Action action : actions) set |= 1U << static_cast<unsigned>(action);
  return static_cast<ActionSet>(set);
}

ActionSet Cautious(const State& state, const char* options = "caution=40") {
  return Survival(ParseSearchSettings(options), {})
      .CautiousActions(state, 0, LegalActions(state, 0));
}

float Weighed(const State& state, const char* options, float value = 0,
              const GameSettings& game = {}) {
  return Survival(ParseSearchSettings(options), game).Weigh(value, state, 0);
}

TEST(Caution, KeepsOutOfADeadEndThatAnEnemyCanClose) {
  State state = Board({".0.1", "#.##", "#..."}, "agent 1 strength 3");
  EXPECT_FALSE(Has(Cautious(state, "caution=1"), static_cast<std::size_t>(Action::kLeft)));
  EXPECT_TRUE(Has(Cautious(state, "caution=1"), static_cast<std::size_t>(Action::kDown)));
  state.agents[1].ammo = 0;
  EXPECT_TRUE(Has(Cautious(state, "caution=1"), static_cast<std::size_t>(Action::kLeft)));
}

TEST(Caution, LeavesTheOnlyWayOutOfABlast) {
  EXPECT_EQ(Cautious(FromText(kEscape)), SetOf({Action::kRight}));
}

TEST(Caution, IsOffAtZeroAndNeverLeavesNothing) {
  int restricted = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    State state = CrowdedStart({}, seed);
    Rng rng(seed);
    for (int step = 0; step < 15; ++step) Step({}, RandomActions(rng), state);
    if (!state.agents[0].alive) continue;
    const ActionSet legal = LegalActions(state, 0);
    EXPECT_EQ(Cautious(state, "caution=0"), legal);
    const ActionSet cautious = Cautious(state);
    EXPECT_NE(cautious, 0);
    EXPECT_EQ(cautious & ~legal, 0);
    restricted += cautious != legal ? 1 : 0;
  }
  EXPECT_GT(restricted, 20);
}

TEST(Caution, ChoosesAMoveThatItsSearchKeepsTo) {
  for (const char* options : {"simulations=30", "simulations=30,root=gumbel",
                              "simulations=30,forced_playouts=2,exploratory_start=0.5"}) {
    const SearchSettings settings = ParseSearchSettings(options);
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      State state = CrowdedStart({}, seed);
      Rng rng(seed);
      for (int step = 0; step < 10; ++step) Step({}, RandomActions(rng), state);
      if (!state.agents[0].alive || OutcomeOf({}, state).done) continue;
      const SearchResult result = SearchOnce(settings, state, {}, seed);
      const ActionSet cautious = Cautious(state);
      EXPECT_TRUE(Has(cautious, static_cast<std::size_t>(result.best))) << options << " " << seed;
      for (std::size_t action = 0; action < kActionCount && result.searched; ++action) {
        EXPECT_TRUE(Has(cautious, action) || result.target[action] == 0) << options << " " << seed;
      }
    }
  }
}

TEST(Room, IsWorthNothingAtNoWeight) {
  EXPECT_EQ(Weighed(Board({"0.1"}), "room=0,hunt=0", 0.25F), 0.25F);
}

TEST(Room, FallsWithOwnRoomAndRisesAsEnemiesLoseTheirs) {
  const State open = Board({"0...", "....", "...1"});
  const State trapped = Board({"0o#.", "##..", "...1"}, "bomb (0,1) owner 1 life 5 strength 3");
  EXPECT_LT(Weighed(trapped, "room=0.5,hunt=0"), Weighed(open, "room=0.5,hunt=0") - 0.3F);
  const State caught = Board({"1o#.", "##..", "...0"}, "bomb (0,1) owner 0 life 5 strength 3");
  EXPECT_GT(Weighed(caught, "room=0,hunt=0.5"), Weighed(open, "room=0,hunt=0.5") + 0.1F);
}

TEST(Room, FearsBombsThatAreNotYetLaid) {
  // Agent 1 has a bomb for the mouth of the dead end, or none.
  State state = Board({"0.1.", "###."}, "agent 1 strength 3");
  const float armed = Weighed(state, "room=1,hunt=0");
  state.agents[1].ammo = 0;
  EXPECT_LT(armed, Weighed(state, "room=1,hunt=0"));
}

TEST(Room, StaysWithinTheValues) {
  State alone = Board({"0"});
  EXPECT_EQ(Weighed(alone, "room=0,hunt=2"), 1) << "everybody else is dead";
  const State doomed = Board({"0o#", "##"}, "bomb (0,1) owner 1 life 5 strength 3");
  EXPECT_EQ(Weighed(doomed, "room=2,hunt=0"), -1);
}

TEST(Room, TurnsWithTheBoard) {
  const SearchSettings settings = ParseSearchSettings("room=0.7,hunt=0.4");
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    State state = CrowdedStart({}, seed);
    Rng rng(seed);
    for (int step = 0; step < 6; ++step) Step({}, RandomActions(rng), state);
    for (Symmetry symmetry = 0; symmetry < kSymmetryCount; ++symmetry) {
      const State turned = Transform(symmetry, state);
      for (AgentId self = 0; self < kAgentCount; ++self) {
        if (!state.agents[self].alive) continue;
        Survival survival(settings, {});
        EXPECT_EQ(survival.Weigh(0, turned, self), survival.Weigh(0, state, self)) << seed;
      }
    }
  }
}

}  // namespace
}  // namespace powderkeg

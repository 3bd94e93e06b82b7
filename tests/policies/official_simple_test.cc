#include "common/policies/official_simple.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/pommerman/board_reader.h"

namespace powderkeg {
namespace {

using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

// Agent 0 at (5,5) on an empty board, without ammo.
State Open() {
  std::string text;
  for (int row = 0; row < kBoardSize; ++row) {
    text += row == 5 ? ".....0.....\n" : "...........\n";
  }
  State state = FromText(text);
  state.agents[0].ammo = 0;
  return state;
}

State WithAgent(State state, AgentId id, int row, int column) {
  state.agents[id].alive = true;
  state.agents[id].cell = static_cast<std::uint8_t>(CellAt(row, column));
  return state;
}

State WithBomb(State state, int row, int column, int strength) {
  state.AddBomb({.cell = static_cast<std::uint8_t>(CellAt(row, column)),
                 .life = 9,
                 .blast_strength = static_cast<std::uint8_t>(strength)});
  return state;
}

State WithAmmo(State state) {
  state.agents[0].ammo = 1;
  return state;
}

PolicyMemory Remembering(std::initializer_list<std::array<int, 2>> positions,
                         int previous_direction = 0) {
  PolicyMemory memory;
  for (const auto [row, column] : positions) {
    memory.recent[memory.recent_count++] = RememberedPosition(row, column);
  }
  memory.previous_direction = static_cast<std::uint8_t>(previous_direction);
  return memory;
}

constexpr int kCalls = 2000;

// How often each action of agent 0 comes out of kCalls calls.
std::array<int, kActionCount> Counts(const State& state, const PolicyMemory& memory = {},
                                     const GameSettings& settings = {},
                                     BitBoard visible = BitBoard::All()) {
  std::array<int, kActionCount> counts{};
  Rng rng(1);
  for (int i = 0; i < kCalls; ++i) {
    PolicyMemory copy = memory;
    ++counts[static_cast<int>(DecideOfficialSimple({state, settings, 0, visible}, copy, rng))];
  }
  return counts;
}

std::vector<Action> Played(const State& state, const PolicyMemory& memory = {},
                           const GameSettings& settings = {}, BitBoard visible = BitBoard::All()) {
  const auto counts = Counts(state, memory, settings, visible);
  std::vector<Action> played;
  for (int action = 0; action < kActionCount; ++action) {
    if (counts[action] > 0) played.push_back(static_cast<Action>(action));
  }
  return played;
}

PolicyMemory MemoryAfter(const State& state, PolicyMemory memory = {}) {
  Rng rng(1);
  (void)DecideOfficialSimple({state, GameSettings(), 0}, memory, rng);
  return memory;
}

TEST(OfficialSimpleTest, LeavesTheLineOfABomb) {
  EXPECT_THAT(Played(WithBomb(Open(), 5, 7, 3)),
              UnorderedElementsAre(Action::kUp, Action::kDown, Action::kLeft));
}

TEST(OfficialSimpleTest, IgnoresBombsOutOfReachOrBehindWalls) {
  EXPECT_EQ(Played(WithBomb(Open(), 5, 9, 2)).size(), 4);
  State walled = WithBomb(Open(), 5, 7, 2);
  walled.rigid.Add(CellAt(5, 6));
  EXPECT_THAT(Played(walled),
              UnorderedElementsAre(Action::kUp, Action::kDown, Action::kLeft));  // not threatened
  EXPECT_EQ(MemoryAfter(walled).recent_count, 1);                                // but wanders
  EXPECT_EQ(MemoryAfter(WithBomb(Open(), 5, 7, 2)).recent_count, 0);
}

TEST(OfficialSimpleTest, LeavesItsOwnBombByTheFirstDirectionThatIsNotStuck) {
  EXPECT_THAT(Played(WithBomb(Open(), 5, 5, 2)), ElementsAre(Action::kRight));
  State dead_end = WithBomb(Open(), 5, 5, 9);
  // Right of it is a tunnel that ends at the edge.
  for (int column = 6; column < kBoardSize; ++column) {
    dead_end.rigid.Add(CellAt(4, column));
    dead_end.rigid.Add(CellAt(6, column));
  }
  EXPECT_THAT(Played(dead_end), ElementsAre(Action::kLeft));
  // A short reach makes the end of the tunnel far enough.
  dead_end.bombs[0].blast_strength = 3;
  EXPECT_THAT(Played(dead_end), ElementsAre(Action::kRight));
}

TEST(OfficialSimpleTest, StopsOnABombWithoutWayOut) {
  State state = WithBomb(Open(), 5, 5, 2);
  state.rigid = BitBoard::Of(CellAt(5, 5)).Neighbours();
  EXPECT_THAT(Played(state), ElementsAre(Action::kStop));
}

TEST(OfficialSimpleTest, ThreatenedFromAllFreeSidesItWalksOnIntoAnyOfThem) {
  State state = WithBomb(WithBomb(Open(), 5, 8, 4), 3, 5, 4);
  state.rigid.Add(CellAt(6, 5));
  state.rigid.Add(CellAt(5, 4));
  EXPECT_THAT(Played(state), UnorderedElementsAre(Action::kUp, Action::kRight));
}

TEST(OfficialSimpleTest, BombsAnAdjacentEnemyIfItCanFlee) {
  EXPECT_THAT(Played(WithAmmo(WithAgent(Open(), 1, 5, 6))), ElementsAre(Action::kBomb));
  EXPECT_THAT(Played(WithAgent(Open(), 1, 5, 6)), ElementsAre(Action::kRight));  // no ammo
  State tunnel = WithAmmo(WithAgent(Open(), 1, 5, 6));
  tunnel.rigid = ~BitBoard::Row(5);
  tunnel.rigid.Add(CellAt(5, 2));
  EXPECT_THAT(Played(tunnel), ElementsAre(Action::kRight));  // no refuge within the tunnel
  tunnel.rigid.Remove(CellAt(5, 2));
  EXPECT_THAT(Played(tunnel), ElementsAre(Action::kBomb));  // one at distance 3
}

TEST(OfficialSimpleTest, StopsWhereTheOriginalFails) {
  State state = WithAmmo(WithAgent(Open(), 1, 5, 6));
  state.rigid = ~(BitBoard::Of(CellAt(5, 5)) | BitBoard::Of(CellAt(5, 6)));
  EXPECT_THAT(Played(state), ElementsAre(Action::kStop));
}

TEST(OfficialSimpleTest, TeamMatesAreNoEnemies) {
  const State state = WithAmmo(WithAgent(Open(), 2, 5, 6));
  EXPECT_THAT(Played(state), ElementsAre(Action::kBomb));
  // It wanders, and would even walk onto the cell of its mate.
  EXPECT_EQ(Played(state, {}, {.mode = Mode::kTeam}).size(), 4);
}

TEST(OfficialSimpleTest, ApproachesTheLastOfTheNearestEnemies) {
  const State state = WithAgent(WithAgent(Open(), 1, 3, 5), 3, 5, 7);
  EXPECT_THAT(Played(state), ElementsAre(Action::kRight));
  EXPECT_EQ(MemoryAfter(state).previous_direction, static_cast<int>(Action::kRight));
}

TEST(OfficialSimpleTest, RepeatsAnApproachEverySecondTime) {
  const auto counts = Counts(WithAgent(Open(), 1, 5, 8), Remembering({}, 4));
  // Half the calls approach, the others wander uniformly in four directions.
  EXPECT_NEAR(counts[4], kCalls * 5 / 8, 100);
  EXPECT_NEAR(counts[1], kCalls / 8, 60);
}

// A later found predecessor replaces the earlier one with probability 1/2.
TEST(OfficialSimpleTest, DrawsAmongEqualPaths) {
  const auto diagonal = Counts(WithAgent(Open(), 1, 6, 6));
  EXPECT_NEAR(diagonal[2], kCalls / 2, 100);  // first found by down
  EXPECT_NEAR(diagonal[4], kCalls / 2, 100);
  // (3,6): found from (3,5), which only up leads to, then from (4,6), by up or right alike.
  const auto knight = Counts(WithAgent(Open(), 1, 3, 6));
  EXPECT_NEAR(knight[1], kCalls * 3 / 4, 100);
  EXPECT_NEAR(knight[4], kCalls / 4, 100);
}

TEST(OfficialSimpleTest, CollectsTheLastOfTheNearestItems) {
  State state = Open();
  state.SetItem(CellAt(5, 7), Item::kKick);
  state.SetItem(CellAt(3, 5), Item::kExtraBomb);
  EXPECT_THAT(Played(state), ElementsAre(Action::kRight));
  state.SetItem(CellAt(4, 5), Item::kExtraBomb);
  EXPECT_THAT(Played(state), ElementsAre(Action::kUp));
  State far = Open();
  far.SetItem(CellAt(5, 8), Item::kKick);
  EXPECT_EQ(Played(far).size(), 4);
}

TEST(OfficialSimpleTest, BombsAdjacentWoodOrWaits) {
  State state = Open();
  state.wood.Add(CellAt(5, 6));
  EXPECT_THAT(Played(state), ElementsAre(Action::kStop));
  EXPECT_THAT(Played(WithAmmo(state)), ElementsAre(Action::kBomb));
}

TEST(OfficialSimpleTest, StepsTowardsWoodUnlessIntoABombsLine) {
  State state = Open();
  state.wood.Add(CellAt(5, 7));
  EXPECT_THAT(Played(state), ElementsAre(Action::kRight));
  state = WithBomb(state, 7, 6, 3);
  EXPECT_THAT(Played(state), UnorderedElementsAre(Action::kUp, Action::kLeft, Action::kDown));
}

TEST(OfficialSimpleTest, WandersToFreshCells) {
  EXPECT_THAT(Played(Open(), Remembering({{4, 5}, {5, 4}, {5, 5}})),
              UnorderedElementsAre(Action::kDown, Action::kRight));
  const auto nowhere_fresh = Remembering({{4, 5}, {5, 4}, {5, 5}, {6, 5}, {5, 6}});
  EXPECT_EQ(Played(Open(), nowhere_fresh).size(), 4);
  State enclosed = Open();
  enclosed.rigid = BitBoard::Of(CellAt(5, 5)).Neighbours();
  EXPECT_THAT(Played(enclosed), ElementsAre(Action::kStop));
  const PolicyMemory memory =
      MemoryAfter(Open(), Remembering({{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}, {5, 0}}));
  EXPECT_EQ(memory.recent_count, 6);
  EXPECT_EQ(memory.recent[0], RememberedPosition(1, 0));
  EXPECT_EQ(memory.recent[5], RememberedPosition(5, 5));
}

TEST(OfficialSimpleTest, SearchMissesTheFarRowFromTheTopRow) {
  // A tunnel along column 0: the only passage further than the own strength is in row 10.
  State state = WithAmmo(Open());
  state.agents[0].cell = 0;
  state.agents[0].blast_strength = 9;
  state.rigid = ~BitBoard::Column(0);
  state.wood.Add(CellAt(0, 1));
  state.rigid.Remove(CellAt(0, 1));
  EXPECT_THAT(Played(state), ElementsAre(Action::kStop));
  state.agents[0].cell = static_cast<std::uint8_t>(CellAt(1, 0));
  state.wood.Add(CellAt(1, 1));
  state.rigid.Remove(CellAt(1, 1));
  state.agents[0].blast_strength = 8;
  EXPECT_THAT(Played(state), ElementsAre(Action::kBomb));
}

TEST(OfficialSimpleTest, SeesNothingInTheFog) {
  const State state = WithBomb(WithAgent(Open(), 1, 5, 8), 5, 7, 5);
  const BitBoard visible = BitBoard::Of(CellAt(5, 5)) | BitBoard::Of(CellAt(5, 5)).Neighbours();
  EXPECT_EQ(Played(state, {}, {}, visible).size(), 4);
}

}  // namespace
}  // namespace powderkeg
